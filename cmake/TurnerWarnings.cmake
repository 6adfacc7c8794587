# Compiler flags of all targets.
add_library(turner_warnings INTERFACE)
target_compile_options(turner_warnings INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wvla
  -Wno-missing-field-initializers
  # IEEE arithmetic as written: the reference's last bits must not depend on the compiler's taste.
  -ffp-contract=off
  # g++ 12.2 loses double(float(x)) where it vectorises straight-line code: two components of three stay unrounded
  # (RoundScene.GivesValuesThatAreFloats catches it).
  $<$<CXX_COMPILER_ID:GNU>:-fno-tree-slp-vectorize>)
if(TURNER_SANITIZE)
  target_compile_options(turner_warnings INTERFACE -fsanitize=address,undefined -fno-sanitize-recover=undefined
    -fno-sanitize=vptr  # glslang comes without run-time type information
    -fno-omit-frame-pointer
    # The checks between the statements mislead it: g++ 12 finds std::regex itself uninitialised.
    $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  target_link_options(turner_warnings INTERFACE -fsanitize=address,undefined)
endif()
