#include <benchmark/benchmark.h>

#include "lab/descriptors/descriptor_model.h"

namespace cairn {
namespace {

void BM_Describe(benchmark::State& state) {
  const DescriptorModel model({});
  DescriptorLook look;
  for (auto _ : state) {
    look.ornament = ++look.landmark;
    look.view_azimuth_rad = 0.3;
    look.log2_scale = -0.2;
    benchmark::DoNotOptimize(model.Describe(look));
  }
}
BENCHMARK(BM_Describe);

}  // namespace
}  // namespace cairn
