// What a kernel checks whose sources are edited: the host compiles them with EDITED defined, and its own sources without
// (host/kernel/edits/edited_kernel). A kernel is specialised to its scene; here it finds out whether what was edited needs more
// than that, and says so in status.lacks, bit kSpec<Name> for a specialisation constant. The host then compiles that in
// and traces once more, or refuses.
#ifdef EDITED
uint lacks = 0u;
#define LACKS(Name, condition) \
  if (condition) lacks |= 1u << kSpec##Name
#define TELL_LACKS() \
  if (lacks != 0u) atomicOr(status.lacks, lacks)
#else
#define LACKS(Name, condition)
#define TELL_LACKS()
#endif
