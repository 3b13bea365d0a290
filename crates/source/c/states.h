/* Saved states: bytes outside of the core, so that there may be any number. The edge names the core's
 * functions of its version of the standard. */

static Saved** find(Instance* s, const void* state) {
  Saved** place = &s->states;
  while (*place && *place != state) place = &(*place)->next;
  return *place ? place : 0;
}

/* The state inside as bytes, in `*state`, which is made where it is null. */
static int keep(Instance* s, const char* function, void** state) {
  uint32_t place = room_for(s, ROOM), size;
  Saved* saved = (Saved*)*state;
  int status = (int)CORE_STATE_SIZE(&s->core, s->fmu, s->state, place);
  if (status > STATUS_WARNING) return status;
  memcpy(&size, at(s, place), 4);
  if (saved && saved->size != size) return refused(s, function, "this FMU state belongs to another model", "", "");
  place = room_for(s, size);
  status = (int)CORE_SERIALIZE(&s->core, s->fmu, s->state, place, size);
  if (status > STATUS_WARNING) return status;
  if (!saved) {
    saved = (Saved*)s->allocate(1, sizeof(Saved) + size);
    if (!saved) return refused(s, function, "there is no memory for an FMU state", "", "");
    saved->next = s->states;
    saved->size = size;
    s->states = saved;
  }
  memcpy(saved + 1, at(s, place), size);
  *state = saved;
  return status;
}

/* Calls a function of the core that takes the place of the state inside. */
static int with_place(Instance* s, const void* bytes, size_t size, bool is_given) {
  uint32_t place = room_for(s, (uint32_t)(size + 16));
  uint32_t b = bytes ? put(s, &place, bytes, size) : 0;
  int status;
  memcpy(at(s, place), &s->state, 4);
  status = (int)(is_given ? CORE_DESERIALIZE(&s->core, s->fmu, b, (u32)size, place) : CORE_GET_STATE(&s->core, s->fmu, place));
  memcpy(&s->state, at(s, place), 4);
  return status;
}

static int get_state(Instance* s, const char* function, void** state) {
  int status;
  if (!state) return (int)CORE_GET_STATE(&s->core, s->fmu, 0);
  status = with_place(s, 0, 0, false);
  return status > STATUS_WARNING ? status : keep(s, function, state);
}

static int set_state(Instance* s, const void* state) {
  const Saved* saved = (const Saved*)state;
  int status;
  if (!saved) return (int)CORE_SET_STATE(&s->core, s->fmu, 0);
  status = with_place(s, saved + 1, saved->size, true);
  return status > STATUS_WARNING ? status : (int)CORE_SET_STATE(&s->core, s->fmu, s->state);
}

static int free_state(Instance* s, const char* function, void** state) {
  Saved **place, *saved;
  if (!state || !*state) return STATUS_OK;
  place = find(s, *state);
  if (!place) return refused(s, function, "this FMU state was saved by another instance", "", "; free it with that one");
  saved = *place;
  *place = saved->next;
  s->release(saved);
  *state = 0;
  return STATUS_OK;
}

static int state_size(Instance* s, const void* state, size_t* size) {
  if (!state || !size) return (int)CORE_STATE_SIZE(&s->core, s->fmu, state ? s->state : 0, size ? s->room : 0);
  *size = ((const Saved*)state)->size;
  return STATUS_OK;
}

static int serialize(Instance* s, const char* function, const void* state, void* bytes, size_t size) {
  const Saved* saved = (const Saved*)state;
  if (!saved) return (int)CORE_SERIALIZE(&s->core, s->fmu, 0, 0, 0);
  if (size < saved->size) return refused(s, function, "the serialised state has more bytes than there is room for", "", "; ask for the size first");
  if (!bytes) return refused(s, function, "serializedState is a null pointer", "", "; give room for the state");
  memcpy(bytes, saved + 1, saved->size);
  return STATUS_OK;
}

static int deserialize(Instance* s, const char* function, const void* bytes, size_t size, void** state) {
  int status;
  if (size > MOST_BYTES) return refused(s, function, "no state has so many bytes", "", "; give the number that was serialised");
  if (!state) return (int)CORE_DESERIALIZE(&s->core, s->fmu, s->room, 0, 0);
  status = with_place(s, bytes, size, true);
  return status > STATUS_WARNING ? status : keep(s, function, state);
}

static void warm_up(Instance* s) {
  uint32_t place, size, length;
  if (with_place(s, 0, 0, false) > STATUS_WARNING) return;
  place = s->room;
  if (CORE_STATE_SIZE(&s->core, s->fmu, s->state, place) > STATUS_WARNING) return;
  memcpy(&size, at(s, place), 4);
  place = room_for(s, size + 16);
  length = size;
  if (CORE_SERIALIZE(&s->core, s->fmu, s->state, place, size) > STATUS_WARNING) return;
  place += (length + 7) & ~7u;
  memcpy(at(s, place), &s->state, 4);
  CORE_DESERIALIZE(&s->core, s->fmu, s->room, size, place);
  memcpy(&s->state, at(s, place), 4);
}
