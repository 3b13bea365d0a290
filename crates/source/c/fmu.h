/* Around the core: an instance, its memory, its end by a trap, arguments in and results out. The rules and
 * messages of the standard are the core's own, those of Piezoloop's shared library. */

/* Where to return to after a trap. */
#if defined(__GNUC__) && !defined(__clang__)
typedef void* Return[5];
#define RETURN_HERE(place) __builtin_setjmp(place)
#define RETURN_TO(place) __builtin_longjmp(place, 1)
#else
#include <setjmp.h>
typedef jmp_buf Return;
#define RETURN_HERE(place) setjmp(place)
#define RETURN_TO(place) longjmp(place, 1)
#endif

/* Instances in several threads at once need a variable per thread; define it as nothing where there is one. */
#ifndef PIEZOLOOP_THREAD_LOCAL
#if defined(_MSC_VER)
#define PIEZOLOOP_THREAD_LOCAL __declspec(thread)
#elif defined(__GNUC__) && (defined(__linux__) || defined(__APPLE__) || defined(_WIN32) || defined(__QNX__))
#define PIEZOLOOP_THREAD_LOCAL __thread
#else
#define PIEZOLOOP_THREAD_LOCAL
#endif
#endif

/* Memory: the importer's functions (FMI 2.0), else with PIEZOLOOP_STATIC_BYTES that many bytes set apart, else
 * the heap. Nothing is asked for after instantiation, except by GetFMUState where it is given no state. */
#ifdef PIEZOLOOP_STATIC_BYTES
static uint64_t arena[(PIEZOLOOP_STATIC_BYTES) / 8];
static size_t arena_used, arena_blocks;
static void* default_allocate(size_t count, size_t size) {
  size_t words = (count * size + 7) / 8;
  void* block = arena + arena_used;
  if (words > (PIEZOLOOP_STATIC_BYTES) / 8 - arena_used) return 0;
  arena_used += words;
  arena_blocks++;
  memset(block, 0, 8 * words);
  return block;
}
/* The room is there again when the last block is given back. */
static void default_release(void* block) {
  if (block && --arena_blocks == 0) arena_used = 0;
}
#else
#include <stdlib.h>
static void* default_allocate(size_t count, size_t size) { return calloc(count, size); }
static void default_release(void* block) { free(block); }
#endif

/* In one call all values of the model twice; longer texts than any category are cut. */
enum { MOST = 2 * (PIEZOLOOP_VALUES) + 64, MOST_TEXTS = 64, LONGEST_TEXT = 63, MOST_BYTES = 1 << 26 };
enum { PAGE = 65536, TEXT = 400, ROOM = 24 * MOST + MOST_TEXTS * (LONGEST_TEXT + 16) + 1024 };
enum { STATUS_OK, STATUS_WARNING, STATUS_DISCARD, STATUS_ERROR };

/* A state that the importer holds; its bytes follow. */
typedef struct Saved {
  struct Saved* next;
  size_t size;
} Saved;

typedef struct Instance {
  w2c_core core;
  Return back;     /* where the present call began */
  uint32_t fmu;    /* the instance inside, 0 where there is none */
  uint32_t state;  /* the saved state inside through which all go */
  uint32_t room, room_size;
  uint64_t reserved; /* pages that the memory may have without moving */
  bool is_built, is_broken, is_logging, is_mute;
  char text[TEXT + 1]; /* of the panic that broke it */
  const char *name, *token;
  Saved* states;
  void* (*allocate)(size_t count, size_t size);
  void (*release)(void* block);
  Importer importer;
} Instance;

static PIEZOLOOP_THREAD_LOCAL Instance* current;

static Instance* instance_of(wasm_rt_memory_t* memory) {
  return (Instance*)((char*)memory - offsetof(Instance, core.w2c_memory));
}

static void wasm_rt_trap(wasm_rt_trap_t code) {
  (void)code;
  RETURN_TO(current->back);
}

/* Reserves at least this many pages; what is there moves along. Their number is a power of two, so that a masked address
 * lies inside, and there is room for one number behind them. */
static bool reserve(Instance* s, wasm_rt_memory_t* memory, uint64_t pages) {
  uint8_t* data;
  uint64_t whole = 1;
  if (pages <= s->reserved) return true;
  while (whole < pages) whole *= 2;
  if (whole > ((size_t)-1) / PAGE / 2) return false;
  data = (uint8_t*)s->allocate((size_t)whole * PAGE + sizeof(uint64_t), 1);
  if (!data) return false;
  if (memory->data) {
    memcpy(data, memory->data, (size_t)memory->size);
    s->release(memory->data);
  }
  memory->data = data;
  memory->mask = (uint8_t*)(uintptr_t)(whole * PAGE - 1);
  s->reserved = whole;
  return true;
}

static void set_pages(wasm_rt_memory_t* memory, uint64_t pages) {
  memory->pages = pages;
  memory->size = pages * PAGE;
  memory->limit = (uint8_t*)(uintptr_t)memory->size;
}

static void wasm_rt_allocate_memory(wasm_rt_memory_t* memory, uint64_t pages, uint64_t max, bool is64, uint32_t page) {
  Instance* s = instance_of(memory);
  (void)is64;
  (void)page;
  memory->max_pages = max;
  if (!reserve(s, memory, pages > PIEZOLOOP_PAGES ? pages : PIEZOLOOP_PAGES)) RETURN_TO(s->back);
  set_pages(memory, pages);
}

static uint64_t wasm_rt_grow_memory(wasm_rt_memory_t* memory, uint64_t pages) {
  Instance* s = instance_of(memory);
  uint64_t before = memory->pages;
  if (pages > memory->max_pages - before) return (uint32_t)-1;
  if (before + pages > s->reserved && (s->is_built || !reserve(s, memory, before + pages))) return (uint32_t)-1;
  set_pages(memory, before + pages);
  return before;
}

static void wasm_rt_free_memory(wasm_rt_memory_t* memory) {
  if (memory->data) instance_of(memory)->release(memory->data);
}

static void wasm_rt_allocate_funcref_table(wasm_rt_funcref_table_t* table, uint32_t count, uint32_t max) {
  if (!table->data) table->data = (wasm_rt_funcref_t*)current->allocate(count, sizeof(wasm_rt_funcref_t));
  if (!table->data) RETURN_TO(current->back);
  table->size = count;
  table->max_size = max;
}

static void wasm_rt_free_funcref_table(wasm_rt_funcref_table_t* table) {
  if (table->data) current->release(table->data);
}

/* The address in the core's memory; 0 is the null pointer. */
static void* at(Instance* s, uint32_t address) { return s->core.w2c_memory.data + address; }

/* The length of a text, 0 of none. Compilers put `strlen` in place of such a loop, which a program without a C library
 * does not have; not where each byte must be read. */
static size_t length_of(const char* text) {
  const volatile char* bytes = text;
  size_t length = 0;
  while (bytes && bytes[length]) length++;
  return length;
}

/* Whether this many bytes lie at the address: what the core hands out is looked at before it is read. */
static bool lies_inside(Instance* s, uint32_t address, uint64_t length) {
  return address + length <= s->core.w2c_memory.size;
}

/* A text of the core; empty where it has no end. */
static const char* text_at(Instance* s, uint32_t address) {
  const char* memory = (const char*)s->core.w2c_memory.data;
  uint64_t end = address;
  while (end < s->core.w2c_memory.size && memory[end]) end++;
  return end < s->core.w2c_memory.size ? memory + address : "";
}

static void w2c_host_tell_importer(struct w2c_host* host, u32 status, u32 category, u32 message) {
  Instance* s = (Instance*)host;
  Return back;
  if (s->is_mute) return;
  memcpy(back, s->back, sizeof back);
  tell_importer(&s->importer, (int)status, text_at(s, category), text_at(s, message));
  /* The importer may have called this instance from there. */
  memcpy(s->back, back, sizeof back);
  current = s;
}

static void w2c_host_keep_panic(struct w2c_host* host, u32 text, u32 length) {
  Instance* s = (Instance*)host;
  size_t kept = length < TEXT ? length : TEXT;
  if (!lies_inside(s, text, length)) return;
  memcpy(s->text, at(s, text), kept);
  s->text[kept] = 0;
}

/* Adds to a message, marks doubled as the core does it. */
static char* add(char* place, const char* end, const char* text) {
  for (; *text && place + 2 < end; text++) {
    if (*text == '#' || (*text == '%' && IS_V2)) *place++ = *text;
    *place++ = *text == '\n' ? ' ' : *text;
  }
  *place = 0;
  return place;
}

/* Brings the core into the state Error, as every error does there: by a function that it always refuses. */
static void note_error(Instance* s) {
  s->is_mute = true;
  CORE_NEVER(&s->core, s->fmu);
  s->is_mute = false;
}

/* Tells of an error that the core does not know of; FMI 2.0 wants the reason even where logging is off. */
static int refused(Instance* s, const char* function, const char* why, const char* more, const char* way_out) {
  char message[2 * TEXT];
  const char* end = message + sizeof message;
  char* place = add(add(message, end, function), end, ": ");
  add(add(add(place, end, why), end, more), end, way_out);
  if (!s->is_broken) note_error(s);
  if (s->is_logging || IS_V2) tell_importer(&s->importer, STATUS_ERROR, "logStatusError", message);
  return STATUS_ERROR;
}

/* The answer of a function that ended in a trap, and of all after it. */
static int trapped(Instance* s, const char* function) {
  static const char unknown[] = "its memory is exhausted or damaged";
  if (!s->text[0]) memcpy(s->text, unknown, sizeof unknown);
  s->is_broken = true;
  return refused(s, function, "internal defect, please report it: ", s->text,
                 "; other instances are not affected, and this one can be reset or freed");
}

/* Room for all arguments and results of one call. */
static uint32_t room_for(Instance* s, uint32_t size) {
  if (size > s->room_size) {
    s->room = w2c_core_piezoloop_room(&s->core, size);
    s->room_size = size;
  }
  return s->room;
}

/* Copies an argument to the place and moves the place on; a null pointer stays one. */
static uint32_t put(Instance* s, uint32_t* place, const void* from, size_t size) {
  uint32_t here = *place;
  if (!from) return 0;
  memcpy(at(s, here), from, size);
  *place += (uint32_t)((size + 7) & ~(size_t)7);
  return here;
}

/* Sets room apart for a result at the place. */
static uint32_t leave(uint32_t* place, const void* wanted, size_t size) {
  uint32_t here = *place;
  if (!wanted) return 0;
  *place += (uint32_t)((size + 7) & ~(size_t)7);
  return here;
}

/* Begins a call: from here on a trap ends it with an error. */
#define ENTER(pointer, name)                \
  Instance* s = (Instance*)(pointer);       \
  const char* const function = name;        \
  if (!s) return (Status)STATUS_ERROR;      \
  current = s;                              \
  if (s->is_broken || RETURN_HERE(s->back)) \
    return (Status)trapped(s, function)
/* As ENTER; a broken instance is made anew first. */
#define ENTER_ANEW(pointer, name)           \
  Instance* s = (Instance*)(pointer);       \
  const char* const function = name;        \
  if (!s) return (Status)STATUS_ERROR;      \
  current = s;                              \
  if (RETURN_HERE(s->back))                 \
    return (Status)trapped(s, function);    \
  if (s->is_broken) build(s)
/* So that the room that was made at instantiation is enough. */
#define AT_MOST(count, most) \
  if ((count) > (size_t)(most)) return (Status)refused(s, function, "no model has so many values", "", "; give the number in the arrays")

/* Through a saved state and back, so that there is memory for it. */
static void warm_up(Instance* s);

/* Makes the core's instance; what was in the memory is gone. Returns by a trap where there is no room. */
static void build(Instance* s) {
  uint32_t place;
  s->is_built = false;
  s->fmu = s->state = s->room = s->room_size = 0;
  s->text[0] = 0;
  if (s->core.w2c_memory.data) memset(s->core.w2c_memory.data, 0, (size_t)(s->reserved * PAGE));
  wasm2c_core_instantiate(&s->core, (struct w2c_host*)s);
  place = w2c_core_piezoloop_spec(&s->core, PIEZOLOOP_MODEL_SIZE);
  memcpy(at(s, place), PIEZOLOOP_MODEL, PIEZOLOOP_MODEL_SIZE);
  room_for(s, ROOM);
  s->fmu = instantiate(s);
  if (s->fmu) warm_up(s);
  /* A page for messages and the like. */
  if (!reserve(s, &s->core.w2c_memory, s->core.w2c_memory.pages + 1)) RETURN_TO(s->back);
  s->is_built = true;
  s->is_broken = false;
}

/* An instance in the importer's memory; null with a message where there is none. */
static Instance* create(Importer importer, void* (*allocate)(size_t, size_t), void (*release)(void*), const char* name,
                        const char* token, bool is_logging) {
  size_t length = length_of(name);
  Instance* s = (Instance*)allocate(1, sizeof(Instance) + length + 1);
  if (!s) {
    importer.name = name;
    tell_importer(&importer, STATUS_ERROR, "logStatusError", "instantiation: there is no memory for an instance");
    return 0;
  }
  if (name) memcpy(s + 1, name, length);
  s->name = name ? (const char*)(s + 1) : 0;
  s->token = token;
  s->importer = importer;
  s->importer.name = s->name;
  s->allocate = allocate;
  s->release = release;
  s->is_logging = is_logging;
  current = s;
  if (RETURN_HERE(s->back)) {
    s->is_logging = true;
    s->fmu = 0;
    trapped(s, "instantiation");
  } else {
    build(s);
  }
  if (!s->fmu) {
    wasm2c_core_free(&s->core);
    release(s);
    return 0;
  }
  s->token = PIEZOLOOP_TOKEN;
  return s;
}

static void destroy(Instance* s) {
  current = s;
  while (s->states) {
    Saved* first = s->states;
    s->states = first->next;
    s->release(first);
  }
  wasm2c_core_free(&s->core);
  s->release(s);
}

/* Copies texts in, and then the addresses of the copies. */
static uint32_t put_texts(Instance* s, const char* const* texts, size_t count) {
  size_t size = 8, length;
  uint32_t place, list, text;
  for (size_t k = 0; texts && k < count; k++) {
    for (length = 0; texts[k] && texts[k][length] && length < LONGEST_TEXT; length++) {}
    size += length + 16;
  }
  list = place = room_for(s, (uint32_t)(size + 4 * count));
  if (!texts) return 0;
  place += (uint32_t)((4 * count + 7) & ~(size_t)7);
  for (size_t k = 0; k < count; k++) {
    for (length = 0; texts[k] && texts[k][length] && length < LONGEST_TEXT; length++) {}
    text = put(s, &place, texts[k], length);
    if (text) memset((char*)at(s, text) + length, 0, 1), place = text + (uint32_t)((length + 8) & ~(size_t)7);
    memcpy(at(s, list + (uint32_t)(4 * k)), &text, 4);
  }
  return list;
}

static void put_name_and_token(Instance* s, uint32_t* name, uint32_t* token) {
  size_t name_length = length_of(s->name), token_length = length_of(s->token);
  uint32_t place;
  place = room_for(s, (uint32_t)(name_length + token_length + 32));
  *name = put(s, &place, s->name, name_length + 1);
  *token = put(s, &place, s->token, token_length + 1);
}

typedef u32 Values2(w2c_core*, u32, u32, u32, u32);
typedef u32 Values3(w2c_core*, u32, u32, u32, u32, u32);

/* A call with references and values, in or out; `one` calls what the version of the standard has. */
static int values(Instance* s, Values2* two, Values3* three, const void* references, size_t count, const void* in, void* out,
                  size_t number, size_t size) {
  uint32_t place = room_for(s, (uint32_t)(4 * count + number * size + 16));
  uint32_t r = put(s, &place, references, 4 * count);
  uint32_t v = in ? put(s, &place, in, number * size) : leave(&place, out, number * size);
  int status = (int)(two ? two(&s->core, s->fmu, r, (u32)count, v)
                         : three(&s->core, s->fmu, r, (u32)count, v, (u32)number));
  if (v && out && status <= STATUS_WARNING) memcpy(out, at(s, v), number * size);
  return status;
}
