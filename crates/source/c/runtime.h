/* What the C of wasm2c asks for, and nothing of a platform: no files, signals, threads, or pages. The memory
 * of an instance is one block of its own. Everything is static, so that FMUs link into one program. */
#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__) || \
    (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "Compile without -ffast-math, -Ofast and their like: they change the results."
#endif
#include <float.h>
#if defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD != 0 && FLT_EVAL_METHOD != 1
#error "Doubles must be computed as doubles; on 32-bit x86 compile with -msse2 -mfpmath=sse."
#endif
#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "Big-endian processors are not supported."
#endif
/* The same bits with and without a fused multiply-add. */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC optimize("fp-contract=off")
#pragma GCC diagnostic ignored "-Wunused-function"
#endif
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#if defined(__GNUC__)
#define LIKELY(x) __builtin_expect(!!(x), 1)
#define UNLIKELY(x) __builtin_expect(!!(x), 0)
#define INFINITY (__builtin_inff())
#define NAN (__builtin_nanf(""))
#define fabs(x) __builtin_fabs(x)
#define fabsf(x) __builtin_fabsf(x)
#define copysign(x, y) __builtin_copysign(x, y)
#define copysignf(x, y) __builtin_copysignf(x, y)
#define signbit(x) __builtin_signbit(x)
#define isnan(x) ((x) != (x))
#else
#include <math.h>
#define LIKELY(x) (x)
#define UNLIKELY(x) (x)
#endif
#ifndef __has_builtin
#define __has_builtin(x) PIEZOLOOP_HAS_BUILTINS
#endif
#if defined(__GNUC__)
#define PIEZOLOOP_HAS_BUILTINS 1
#else
#define PIEZOLOOP_HAS_BUILTINS 0
#endif

#define WABT_BIG_ENDIAN 0
#define WASM_RT_USE_SEGUE 0
#define WASM_RT_SEGUE_FREE_SEGMENT 0
#define WASM_RT_SANITY_CHECKS 0
#define WASM_RT_STACK_DEPTH_COUNT 0
#define WASM_RT_MEMCHECK_GUARD_PAGES 0
#define wasm_rt_memcpy memcpy
#define wasm_rt_is_initialized() 1
#undef assert
#define assert(condition) ((void)0)

typedef enum {
  WASM_RT_TRAP_NONE,
  WASM_RT_TRAP_OOB,
  WASM_RT_TRAP_INT_OVERFLOW,
  WASM_RT_TRAP_DIV_BY_ZERO,
  WASM_RT_TRAP_INVALID_CONVERSION,
  WASM_RT_TRAP_UNREACHABLE,
  WASM_RT_TRAP_CALL_INDIRECT,
  WASM_RT_TRAP_EXHAUSTION
} wasm_rt_trap_t;

typedef void (*wasm_rt_function_ptr_t)(void);
typedef struct wasm_rt_tailcallee_t {
  void (*fn)(void** instance, void* stack, struct wasm_rt_tailcallee_t* next);
} wasm_rt_tailcallee_t;
typedef const char* wasm_rt_func_type_t;

typedef struct {
  wasm_rt_func_type_t func_type;
  wasm_rt_function_ptr_t func;
  wasm_rt_tailcallee_t func_tailcallee;
  void* module_instance;
} wasm_rt_funcref_t;
typedef void* wasm_rt_externref_t;
static const wasm_rt_funcref_t wasm_rt_funcref_null_value = {0, 0, {0}, 0};
#define wasm_rt_externref_null_value ((wasm_rt_externref_t)0)

/* `mask` and `limit` are numbers kept as pointers: what the core writes to its memory are numbers, so that a compiler
 * need not read these fields anew after each write. */
typedef struct {
  uint8_t *data, *mask, *limit;
  uint64_t pages, max_pages, size;
} wasm_rt_memory_t;
#define MASK(memory) ((uint64_t)(uintptr_t)(memory)->mask)
#define LIMIT(memory) ((uint64_t)(uintptr_t)(memory)->limit)

/* A number at any place of the memory. */
#if defined(__GNUC__)
typedef union __attribute__((packed)) {
  uint8_t u8_;
  int8_t s8_;
  uint16_t u16_;
  int16_t s16_;
  uint32_t u32_;
  int32_t s32_;
  uint64_t u64_;
  int64_t s64_;
  float f32_;
  double f64_;
} Cell;
#define READ_CELL(number, place, type) number = ((const Cell*)(place))->type##_
#define WRITE_CELL(place, number, type) ((Cell*)(place))->type##_ = number
#else
#define READ_CELL(number, place, type) memcpy(&number, place, sizeof number)
#define WRITE_CELL(place, number, type) memcpy(place, &number, sizeof number)
#endif
typedef struct {
  wasm_rt_funcref_t* data;
  uint32_t max_size, size;
} wasm_rt_funcref_table_t;
typedef struct {
  wasm_rt_externref_t* data;
  uint32_t max_size, size;
} wasm_rt_externref_table_t;

#if defined(__GNUC__)
static void wasm_rt_trap(wasm_rt_trap_t) __attribute__((noreturn, cold));
#else
static void wasm_rt_trap(wasm_rt_trap_t);
#endif
static void wasm_rt_allocate_memory(wasm_rt_memory_t*, uint64_t pages, uint64_t max, bool is64, uint32_t page);
static uint64_t wasm_rt_grow_memory(wasm_rt_memory_t*, uint64_t pages);
static void wasm_rt_free_memory(wasm_rt_memory_t*);
static void wasm_rt_allocate_funcref_table(wasm_rt_funcref_table_t*, uint32_t count, uint32_t max);
static void wasm_rt_free_funcref_table(wasm_rt_funcref_table_t*);
