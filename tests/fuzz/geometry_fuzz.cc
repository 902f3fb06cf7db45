// GeoPackage geometries. A map's layers contain them, and other programs may write them.
#include "fuzz/fuzz_target.h"
#include "storage/inspection/geopackage.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  cairn::EnvelopeOfGeometry({data, size});
  return 0;
}
