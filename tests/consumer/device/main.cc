// Uses the installed headers and libraries to simulate a device that stands in front of a wall for
// two seconds. Tracking must start.
#include <cairn/fusion/client/fusion_client.h>
#include <cairn/fusion/transport/map_transport.h>

#include <cstdint>
#include <cstdio>
#include <utility>
#include <vector>

namespace fusion = cairn::fusion;

// 20 points.
std::vector<fusion::TrackedFeature> Wall() {
  std::vector<fusion::TrackedFeature> points;
  for (uint64_t i = 0; i < 20; ++i) {
    const auto column = static_cast<double>(i % 5), row = static_cast<double>(i / 5);
    points.push_back({i + 1, Eigen::Vector2d(60.0 + 130.0 * column, 60.0 + 120.0 * row)});
  }
  return points;
}

int main() {
  fusion::FusionOptions options;
  options.camera =
      cairn::Camera(cairn::CameraModel::kPinhole, 640, 480, {460.0, 460.0, 320.0, 240.0});
  auto [client, error] = fusion::FusionClient::Create(options);
  if (client == nullptr) {
    std::fprintf(stderr, "%s\n", error.c_str());
    return 1;
  }
  fusion::MapTransportOptions transport_options;
  transport_options.url = "http://localhost:1";  // Nobody is asked.
  const fusion::MapTransport transport(
      transport_options, [&](fusion::Answer answer) { client->Submit(std::move(answer)); });
  const std::vector<fusion::TrackedFeature> wall = Wall();
  constexpr int64_t kSampleNs = 5'000'000;
  for (int i = 0; i <= 400; ++i) {
    const fusion::ImuSample sample = {i * kSampleNs, Eigen::Vector3d::Zero(), {0.0, 0.0, 9.81}};
    client->AddImu({&sample, 1});
    if (i % 20 == 0) {
      client->AddFrame({i * kSampleNs, wall});
    }
  }
  return client->Latest().mode == fusion::Mode::kTracking ? 0 : 1;
}
