// Entering a medium twice, or leaving one that the ray is not in, changes nothing.
#include "reference/nested_dielectrics.h"

#include <algorithm>

namespace turner::reference {
namespace {

void addMedium(Media& media, uint32_t medium) {
  const auto at = std::lower_bound(media.begin(), media.end(), medium);
  if (at == media.end() || *at != medium) media.insert(at, medium);
}

void removeMedium(Media& media, uint32_t medium) {
  const auto at = std::lower_bound(media.begin(), media.end(), medium);
  if (at != media.end() && *at == medium) media.erase(at);
}

// The index of refraction of the active medium, or of air.
double activeEta(const Aggregate& aggregate, const Media& media) {
  return media.empty() ? 1 : aggregate.scene.materials[aggregate.dielectrics.materials[media.back()]].eta;
}

bool isSameGlass(const Aggregate& aggregate, const Media& a, const Media& b) {
  if (a.empty() || b.empty()) return a.empty() == b.empty();
  return aggregate.dielectrics.glasses[a.back()] == aggregate.dielectrics.glasses[b.back()];
}

}  // namespace

Crossing crossInterfaces(const Aggregate& aggregate, const Ray& ray, const Hit& hit, const Surface& surface,
                         const Media& media) {
  Crossing crossing{.beyond = media};
  for (const uint32_t primitive : hit.interfaces)
    if (aggregate.entersMedium(ray, hit.t, primitive)) addMedium(crossing.beyond, aggregate.mediumOf(primitive));
  // Leaves after it entered: at a thin edge a ray may meet both sides of a medium at once, and is out in the end.
  for (const uint32_t primitive : hit.interfaces)
    if (!aggregate.entersMedium(ray, hit.t, primitive)) removeMedium(crossing.beyond, aggregate.mediumOf(primitive));

  double before = activeEta(aggregate, media), behind = activeEta(aggregate, crossing.beyond);
  if (aggregate.mediumOf(surface.primitive) == kNoMedium) {
    // Glass that is no nested medium is on its own back, and whatever the ray is in on its front.
    (surface.front ? behind : before) = surface.material->eta;
  } else {
    crossing.hidden = isSameGlass(aggregate, media, crossing.beyond);
  }
  crossing.etaRatio = behind / before;
  return crossing;
}

}  // namespace turner::reference
