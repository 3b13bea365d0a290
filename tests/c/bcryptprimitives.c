/* Windows 10's source of random bytes, for runs under a wine that lacks it. */
#include <windows.h>

BOOLEAN NTAPI SystemFunction036(PVOID room, ULONG count);

#if defined(__i386__)
/* Windows exports it without the count of bytes that this calling convention puts behind names. */
#define NAMED __asm__("_ProcessPrng")
#else
#define NAMED
#endif
__declspec(dllexport) BOOL WINAPI ProcessPrng(PBYTE room, SIZE_T count) NAMED;
__declspec(dllexport) BOOL WINAPI ProcessPrng(PBYTE room, SIZE_T count) {
    return SystemFunction036(room, (ULONG)count);
}
