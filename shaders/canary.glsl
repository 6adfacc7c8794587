// Whether a driver's loop limiter has fired: lavapipe ends all loops of an invocation after 65,535 iterations, silently.

// A loop that must run kCanaryLength times, after all others. If it does not, the picture is not to be trusted.
void singCanary() {
  uint sung = 0u;
  for (uint i = 0u; i < frame.canaryLength; ++i) ++sung;
  if (sung != kCanaryLength) atomicAdd(status.limiter, 1u);
}
