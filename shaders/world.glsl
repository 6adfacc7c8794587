// The scene's own units. The kernel computes in a frame of its own: the eye is its origin, and a power of two brings the
// camera's target to a distance of 1 to 2 (docs/kernel.md, Numbers). Its axes are those of the scene, so that normals and
// unit directions are the same in both.

// A distance of the kernel in the scene's units, and back.
float worldDistance(const float distance) { return distance / frame.worldScale; }
float localDistance(const float distance) { return distance * frame.worldScale; }

// A point in the scene's coordinates, as the sum of two floats: far from the scene's origin one float alone is coarse, at
// 1e6 by a 32nd.
vec3 worldPoint(const vec3 point, out vec3 rest) {
  vec3 sumRest;
  vec3 sum = twoSum(frame.worldEyeHi, point / frame.worldScale, sumRest);
  return twoSum(sum, sumRest + frame.worldEyeLo, rest);
}

vec3 worldPoint(const vec3 point) {
  vec3 rest;
  return worldPoint(point, rest);
}

vec3 worldPoint(const Surface surface) { return worldPoint(surface.point); }

vec3 worldNormal(const Surface surface) { return surface.Ns; }

// A point of the scene's coordinates in the kernel's. Near the eye it has all its digits.
vec3 localPoint(const vec3 point) { return ((point - frame.worldEyeHi) - frame.worldEyeLo) * frame.worldScale; }

// For textures: the cell of a grid of this size, in the scene's units, that a surface's point is in, and where in it,
// from 0 to 1. The grid stands still while the camera moves, and is as sharp at 1e6 units as at the scene's origin.
// Cells are whole numbers, those beyond 2^24 rounded to what a float can tell.
vec3 worldCell(const Surface surface, const float size, out vec3 within) {
  vec3 rest, productRest, product, sumRest;
  vec3 point = worldPoint(surface.point, rest);
  vec3 cell = floor(point / size);
  product.x = twoProduct(cell.x, size, productRest.x);
  product.y = twoProduct(cell.y, size, productRest.y);
  product.z = twoProduct(cell.z, size, productRest.z);
  vec3 difference = twoSum(point, -product, sumRest);
  precise vec3 inside = (difference + ((sumRest + rest) - productRest)) / size;
  // The quotient was rounded: the point may be in the cell before or behind.
  vec3 carry = floor(inside);
  within = inside - carry;
  return cell + carry;
}

// Whether the sum of a cell's numbers is odd, as on a board of draughts.
bool isOdd(const vec3 cell) {
  float sum = cell.x + cell.y + cell.z;
  return sum - 2.0 * floor(0.5 * sum) > 0.5;
}
