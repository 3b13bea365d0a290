/* Windows 10's source of random bytes, for runs under a wine that lacks it. */
#include <windows.h>

BOOLEAN NTAPI SystemFunction036(PVOID room, ULONG count);

__declspec(dllexport) BOOL WINAPI ProcessPrng(PBYTE room, SIZE_T count) {
    return SystemFunction036(room, (ULONG)count);
}
