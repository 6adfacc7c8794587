// The cube of directions around a point that many rays share: the eye for eye rays (the item buffer of Weghorst, Hooper
// and Greenberg, ACM TOG 3(1), 1984), a light for its shadow rays (the light buffer of Haines and Greenberg, IEEE CG&A
// 6(9), 1986). Each cell has a list of all that a ray through it may hit, sorted by distance from the point, so that
// such a ray begins its traversal deep in the tree, most often at a primitive. The host leaves room for the rounding of all that is
// computed here.

const uint kEyeBuffer = 0u;  // the first light's is the next

// The component of a direction along an axis.
float along(const vec3 direction, const int axis) {
  return axis == 0 ? direction.x : axis == 1 ? direction.y : direction.z;
}

// The face that a direction points to; axis is that of its largest component.
uint directionFace(const vec3 direction, const int axis) {
  return 2u * uint(axis) + (along(direction, axis) < 0.0 ? 1u : 0u);
}

// The list of a direction's cell, u and v on that face of that cube: its first entry, its end, its first pair.
uvec3 cellList(const uint lightBuffer, const uint face, const vec2 uv) {
  Row row = ROW(lightBuffers, kLightBufferRows * lightBuffer + face);
  vec3 window = xyz(row);
  uint side = row.w & 255u;
  // Outside of the window there is nothing: any list will do.
  vec2 position = (uv - window.xy) * window.z;
  float last = float(int(side)) - 0.001;
  position = vec2(lesser(greater(position.x, 0.0), last), lesser(greater(position.y, 0.0), last));
  vec2 cell = floor(position);
  uvec2 fine = ROW(lightBuffers, (row.w >> 8u) + uint(int(cell.y)) * side + uint(int(cell.x))).xy;
  // place - cell is less than 1, and their product with a power of two below it.
  vec2 within = (position - cell) * float(int(fine.y));
  return ROW(lightBuffers, fine.x + uint(int(within.y)) * fine.y + uint(int(within.x))).xyz;
}
