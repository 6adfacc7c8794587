// Interfaces of glass that lie hidden in glass of a higher priority (nested_dielectrics.glsl tells which).

// An interface that is hidden in other glass is not seen: the ray goes straight on.
void passHiddenInterface(const Surface surface, const Crossing crossing) {
  currentRay = leaveSurface(surface, hitPrimitive, currentRay.direction, false);
  media = crossing.beyond;
  ++hiddenInterfaces;
  traversal = startAtRoot();
  phase = kTrace;
  // Every such ray comes to an end, whatever the geometry.
  if (hiddenInterfaces >= kMaxHiddenInterfaces) {
    mediaLost = true;
    phase = kNextRay;
  }
}
