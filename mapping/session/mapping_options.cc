#include "mapping/session/map_photos.h"

namespace cairn {

void MappingOptions::Validate() const {
  sift.Validate();
  pairs.Validate();
  two_views.Validate();
  growth.Validate();
  adjust.Validate();
}

}  // namespace cairn
