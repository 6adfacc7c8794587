// The cube of directions around a point that many rays share: the eye for eye rays (the item buffer of Weghorst, Hooper
// and Greenberg, ACM TOG 3(1), 1984), a light for its shadow rays (the light buffer of Haines and Greenberg, IEEE CG&A
// 6(9), 1986). Each cell has a list of all that a ray through it may hit, sorted by distance from the point, so that
// such a ray begins its traversal deep in the tree, most often at a primitive. The host leaves room for the rounding of
// all that is computed here.

const uint kEyeBuffer = 0u;  // the first light's is the next

// The component of a direction along an axis.
float along(const vec3 direction, const int axis) {
  return axis == 0 ? direction.x : axis == 1 ? direction.y : direction.z;
}

// The face that a direction points to; axis is that of its largest component.
uint directionFace(const vec3 direction, const int axis) {
  return 2u * uint(axis) + (along(direction, axis) < 0.0 ? 1u : 0u);
}

// The cell list of a direction, u and v on that face of that light buffer.
FineCell cellList(const uint lightBuffer, const uint face, const vec2 uv) {
  LightBufferFace window = faceAt(kLightBufferFaces * lightBuffer + face);
  uint side = window.cells & 255u;
  // Outside of the window there is nothing: any list will do.
  vec2 position = (uv - window.corner) * window.cellsPerUnit;
  float last = float(int(side)) - 0.001;
  position = vec2(lesser(greater(position.x, 0.0), last), lesser(greater(position.y, 0.0), last));
  vec2 cell = floor(position);
  CoarseCell coarse = coarseCellAt((window.cells >> 8u) + uint(int(cell.y)) * side + uint(int(cell.x)));
  // position - cell is less than 1, and their product with a power of two below it.
  vec2 within = (position - cell) * float(int(coarse.side));
  return fineCellAt(coarse.firstFineCell + uint(int(within.y)) * coarse.side + uint(int(within.x)));
}
