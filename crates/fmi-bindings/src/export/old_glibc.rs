//! What keeps the library of an FMU loadable where glibc is as old as 2.17 (2012), wherever it is built.
//!
//! A linker binds a function to the newest version that the C library at hand has of it, and older ones do not have
//! that. For the few functions concerned the library of an FMU has definitions of its own, which only it sees: those of
//! files and threads make the system call (the standard library copes where the kernel has none), those of the loader go
//! on to the version that all have. `tests/packed_library.rs` reads what is left.

/// Defines what the standard library calls on every way: `fstat64` and `stat64` (glibc 2.33), `gettid` (2.30), `statx`
/// (2.28), `getrandom` (2.25).
#[macro_export]
macro_rules! old_glibc {
    () => {
        #[cfg(all(target_os = "linux", target_env = "gnu", target_arch = "x86_64"))]
        ::core::arch::global_asm!(
            ".macro piezoloop_own name",
            ".section .text.\\name,\"ax\",@progbits",
            // As the standard library names three of them.
            ".weak \\name",
            ".hidden \\name",
            ".type \\name,@function",
            "\\name:",
            ".endm",
            // int fstat64(int file, struct stat64 *found)
            "piezoloop_own fstat64",
            "mov rdx, rsi",
            "movsxd rsi, edi",
            "mov edi, 5",
            "xor eax, eax",
            "jmp syscall@PLT",
            // int stat64(const char *path, struct stat64 *found)
            "piezoloop_own stat64",
            "mov rdx, rsi",
            "mov rsi, rdi",
            "mov edi, 4",
            "xor eax, eax",
            "jmp syscall@PLT",
            // pid_t gettid(void)
            "piezoloop_own gettid",
            "mov edi, 186",
            "xor eax, eax",
            "jmp syscall@PLT",
            // int statx(int folder, const char *path, int flags, unsigned mask, struct statx *found)
            "piezoloop_own statx",
            "mov r9, r8",
            "mov r8d, ecx",
            "movsxd rcx, edx",
            "mov rdx, rsi",
            "movsxd rsi, edi",
            "mov edi, 332",
            "xor eax, eax",
            "jmp syscall@PLT",
            // ssize_t getrandom(void *bytes, size_t count, unsigned flags)
            "piezoloop_own getrandom",
            "mov ecx, edx",
            "mov rdx, rsi",
            "mov rsi, rdi",
            "mov edi, 318",
            "xor eax, eax",
            "jmp syscall@PLT",
            ".purgem piezoloop_own",
            ".text",
        );
    };
}

/// Defines the functions of the loader, which glibc 2.34 moved: by the version of libdl, which each glibc has.
#[macro_export]
macro_rules! old_glibc_loader {
    () => {
        #[cfg(all(target_os = "linux", target_env = "gnu", target_arch = "x86_64"))]
        ::core::arch::global_asm!(
            ".macro piezoloop_older name",
            ".symver piezoloop_\\name, \\name@GLIBC_2.2.5",
            ".section .text.\\name,\"ax\",@progbits",
            ".globl \\name",
            ".hidden \\name",
            ".type \\name,@function",
            "\\name:",
            "jmp piezoloop_\\name@PLT",
            ".endm",
            "piezoloop_older dlopen",
            "piezoloop_older dlsym",
            "piezoloop_older dlclose",
            "piezoloop_older dlerror",
            ".purgem piezoloop_older",
            ".text",
        );
    };
}
