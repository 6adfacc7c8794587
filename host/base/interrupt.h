// Ctrl-C, a termination and a hang-up end the program in an orderly way: nothing half-written stays behind.
#pragma once

namespace turner {

// From here on the first SIGINT, SIGTERM or SIGHUP is only noted; a second one of the kind ends the process at once.
// A termination or a hang-up that was ignored at the start (nohup) stays ignored.
void catchInterrupts();
// Of a child that ends with its parent, whoever sent the signal to both.
void ignoreInterrupts();
// Throws Interrupted if a signal was noted. Cheap; called between pieces of work.
void throwIfInterrupted();
// The signal that was noted; 0: none.
int interruptSignal();

}  // namespace turner
