// Looks for the solid around each hollow.
#include "geometry/nested_dielectrics/solids.h"

#include <cstdint>
#include <utility>

#include "geometry/nested_dielectrics/bounds_tree.h"

namespace turner::nested_dielectrics {

std::vector<Solid> solidsOf(const std::vector<Surface>& surfaces) {
  std::vector<Solid> solids;
  std::vector<BoundsTree::Item> items;
  for (const Surface& surface : surfaces) {
    if (surface.volume < 0) continue;
    items.push_back({surface.box, uint32_t(solids.size()), 0, surface.volume});
    solids.push_back({{&surface}});
  }
  const BoundsTree tree(std::move(items));
  for (const Surface& surface : surfaces) {
    if (surface.volume > 0) continue;
    const BoundsTree::Item* const smallest = tree.smallestHolding(
        surface.box, -surface.volume,
        [&](const BoundsTree::Item& item) { return solids[item.owner].outer().material == surface.material; });
    if (smallest) solids[smallest->owner].surfaces.push_back(&surface);
  }
  return solids;
}

}  // namespace turner::nested_dielectrics
