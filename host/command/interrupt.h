// Ctrl-C ends the program in an orderly way: nothing half-written stays behind.
#pragma once

namespace turner {

// From here on the first Ctrl-C is only noted; a second one ends the process at once.
void catchInterrupts();

// Throws Interrupted if Ctrl-C was pressed. Cheap; called between pieces of work.
void throwIfInterrupted();

}  // namespace turner
