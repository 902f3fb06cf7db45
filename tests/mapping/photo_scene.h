// A wall and a village that can be photographed, and folders of photos as people have them.
#ifndef CAIRN_TESTS_MAPPING_PHOTO_SCENE_H_
#define CAIRN_TESTS_MAPPING_PHOTO_SCENE_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "cli/demo/street/renderer.h"
#include "core/angles.h"
#include "core/geodesy.h"
#include "core/random.h"
#include "eval/pictures/encode_png.h"
#include "support/exif_bytes.h"

namespace cairn::testing {

// How a photo is taken. The frame is east-north-up at PhotoScene::Origin, meters.
struct Shot {
  std::string name;
  Eigen::Vector3d x_in_enu = Eigen::Vector3d::Zero();
  double yaw_rad = 0.0;    // Counterclockwise from north.
  double pitch_rad = 0.0;  // Upward; -pi/2 looks straight down with north at the top.
  double roll_rad = 0.0;   // Clockwise turn of the camera about its view.
  int width_px = 320, height_px = 240;
  double focal_px = 284.0;
  double gain = 1.0, noise = 1.0;  // See PhotoEffects.
  double blur_px = 0.0;            // Sigma.
  bool has_gps = true;
  Eigen::Vector3d gps_error_m = Eigen::Vector3d::Zero();
  // Place, size and focal length are filled in if they are not set.
  ExifContent exif = {};
};

class PhotoScene {
 public:
  // The wall stands 8 m north of the origin, 40 m long and 9 m high. Boxes of up to `relief_m`
  // stand out of it. `east_m` is its middle.
  explicit PhotoScene(uint64_t seed, double relief_m = 1.5, double east_m = 0.0)
      : renderer_(Build(seed, relief_m, east_m)) {}

  // A level ground around the origin, 160 m from west to east and 120 m from south to north, with
  // `num_houses` of 2 to `height_m` meters. For photos from the air.
  static PhotoScene Village(uint64_t seed, int num_houses, double height_m) {
    cv::RNG rng(seed);
    std::vector<TexturedRect> rects;
    Add({-80.0, 60.0, 0.0}, {160, 0, 0}, {0, -120, 0}, kAerialTexelsPerM, &rng, &rects);
    for (int i = 0; i < num_houses; ++i) {
      const Eigen::Vector3d low(rng.uniform(-75.0, 65.0), rng.uniform(-55.0, 45.0), 0.0);
      const Eigen::Vector3d size(rng.uniform(5.0, 10.0), rng.uniform(5.0, 10.0),
                                 rng.uniform(2.0, height_m));
      AddHouse(low, size, &rng, &rects);
    }
    return PhotoScene(std::move(rects));
  }

  // A wall of 40 x 12 m alone, 8 m north of the origin.
  static PhotoScene FlatWall(uint64_t seed) {
    cv::RNG rng(seed);
    std::vector<TexturedRect> rects;
    Add({-20.0, 8.0, 9.0}, {40, 0, 0}, {0, 0, -12}, kTexelsPerM, &rng, &rects);
    return PhotoScene(std::move(rects));
  }

  static Geodetic Origin() { return Geodetic::FromDegrees(47.3769, 8.5417, 408.0); }

  // The pixels of a photo.
  GrayImage Take(const Shot& shot) const {
    const Camera camera(CameraModel::kPinhole, shot.width_px, shot.height_px,
                        {shot.focal_px, shot.focal_px, 0.5 * shot.width_px, 0.5 * shot.height_px});
    PhotoEffects effects;
    effects.gain = shot.gain;
    effects.noise_sigma = shot.noise;
    effects.noise_seed = std::hash<std::string>()(shot.name);
    GrayImage image = renderer_.Render(camera, CamFromEnu(shot), effects);
    if (shot.blur_px > 0.0) {
      cv::Mat pixels(image.height_px, image.width_px, CV_8UC1, image.pixels.data());
      cv::GaussianBlur(pixels, pixels, {}, shot.blur_px);
    }
    return image;
  }

  static Rigid3d CamFromEnu(const Shot& shot) {
    const Eigen::AngleAxisd yaw(shot.yaw_rad, Eigen::Vector3d::UnitZ());
    const Eigen::AngleAxisd pitch(shot.pitch_rad, Eigen::Vector3d::UnitX());
    const Eigen::AngleAxisd roll(shot.roll_rad, Eigen::Vector3d::UnitY());
    // Right, forward and up of a level camera that looks north are east, north and up.
    Eigen::Matrix3d body_from_cam;
    body_from_cam << 1, 0, 0, 0, 0, 1, 0, -1, 0;
    const Eigen::Quaterniond enu_from_cam((yaw * pitch * roll).toRotationMatrix() * body_from_cam);
    return Rigid3d(enu_from_cam, shot.x_in_enu).Inverse();
  }

 private:
  static constexpr double kTexelsPerM = 40.0, kAerialTexelsPerM = 8.0;

  explicit PhotoScene(std::vector<TexturedRect> rects) : renderer_(std::move(rects)) {}

  static std::shared_ptr<const Texture> Paint(cv::RNG* rng, double width_m, double height_m,
                                              double texels_per_m) {
    const auto side = [&](double meters) {
      return Texture::kSizeStep *
             std::max(1, static_cast<int>(std::lround(meters * texels_per_m / Texture::kSizeStep)));
    };
    cv::Mat sum(side(height_m), side(width_m), CV_32FC1, cv::Scalar(rng->uniform(90.0, 160.0)));
    for (const int cell : {4, 10, 24}) {
      cv::Mat coarse(sum.rows / cell + 2, sum.cols / cell + 2, CV_32FC1), fine;
      rng->fill(coarse, cv::RNG::UNIFORM, -60.0, 60.0);
      cv::resize(coarse, fine, sum.size(), 0, 0, cell == 4 ? cv::INTER_NEAREST : cv::INTER_LINEAR);
      sum += fine;
    }
    cv::Mat pixels;
    sum.convertTo(pixels, CV_8UC1);
    return std::make_shared<Texture>(pixels);
  }

  // Seen from where `u` points to the right and `v` down.
  static void Add(const Eigen::Vector3d& corner, const Eigen::Vector3d& u, const Eigen::Vector3d& v,
                  double texels_per_m, cv::RNG* rng, std::vector<TexturedRect>* rects) {
    rects->push_back({corner, u, v, Paint(rng, u.norm(), v.norm(), texels_per_m)});
  }

  static void AddHouse(const Eigen::Vector3d& low, const Eigen::Vector3d& size, cv::RNG* rng,
                       std::vector<TexturedRect>* rects) {
    const Eigen::Vector3d high = low + size, down(0.0, 0.0, -size.z());
    const auto add = [&](const Eigen::Vector3d& corner, const Eigen::Vector3d& u,
                         const Eigen::Vector3d& v) {
      Add(corner, u, v, kAerialTexelsPerM, rng, rects);
    };
    add({low.x(), high.y(), high.z()}, {size.x(), 0, 0}, {0, -size.y(), 0});  // The roof.
    add({low.x(), low.y(), high.z()}, {size.x(), 0, 0}, down);                // From the south,
    add({high.x(), high.y(), high.z()}, {-size.x(), 0, 0}, down);             // the north,
    add({high.x(), low.y(), high.z()}, {0, size.y(), 0}, down);               // the east,
    add({low.x(), high.y(), high.z()}, {0, -size.y(), 0}, down);              // the west.
  }

  static std::vector<TexturedRect> Build(uint64_t seed, double relief_m, double east_m) {
    cv::RNG rng(seed);
    std::vector<TexturedRect> rects;
    const double wall_m = 8.0;
    const auto add = [&](const Eigen::Vector3d& corner, const Eigen::Vector3d& u,
                         const Eigen::Vector3d& v) {
      Add(corner, u, v, kTexelsPerM, &rng, &rects);
    };
    add({east_m - 20.0, wall_m, 9.0}, {40, 0, 0}, {0, 0, -9});
    add({east_m - 20.0, wall_m, 0.0}, {40, 0, 0}, {0, -14, 0});  // The ground.
    for (int i = 0; relief_m > 0.0 && i < 24; ++i) {
      const double x = east_m + rng.uniform(-19.0, 17.0), z = rng.uniform(0.5, 7.0);
      const double width = rng.uniform(0.8, 2.2), height = rng.uniform(0.8, 2.0);
      const double depth = rng.uniform(0.3, relief_m);
      add({x, wall_m - depth, z + height}, {width, 0, 0}, {0, 0, -height});
      // Boxes on the ground, for photos that look down.
      const double y = rng.uniform(-5.0, 5.0), top = rng.uniform(0.2, relief_m);
      if (std::abs(y) > 1.5) {  // Not where people walk.
        add({x, y + height, top}, {width, 0, 0}, {0, -height, 0});
        add({x, y, top}, {width, 0, 0}, {0, 0, -top});
      }
    }
    return rects;
  }

  Renderer renderer_;
};

// A walk along the wall: photos every 2 m, level, looking at it by turns a little left and right,
// with GPS errors of about a meter.
inline std::vector<Shot> Walk(int num_photos, double east_m = 0.0) {
  std::vector<Shot> shots;
  Random random(17);
  for (int i = 0; i < num_photos; ++i) {
    Shot shot;
    shot.name = "photo" + std::to_string(100 + i) + ".png";
    shot.x_in_enu = {east_m + 2.0 * (i - 0.5 * (num_photos - 1)), i % 3 == 1 ? 0.8 : 0.0, 1.6};
    shot.yaw_rad = 0.12 * (i % 3 - 1);
    for (double& error_m : shot.gps_error_m) {
      error_m = 3.4 * (random.Fraction() - 0.5);
    }
    shots.push_back(shot);
  }
  return shots;
}

// A flight to the east, back to the west and so on: lanes 12 m apart, photos every 8 m, looking
// straight down by about a degree. The camera turns with the flight unless `is_fixed`. Errors of
// GPS have a standard deviation of 1 m along each horizontal axis and of 3 m in height.
inline std::vector<Shot> Flight(int num_lanes, int photos_of_lane, double height_m,
                                bool is_fixed = false) {
  std::vector<Shot> shots;
  cv::RNG rng(29);
  for (int lane = 0; lane < num_lanes; ++lane) {
    for (int i = 0; i < photos_of_lane; ++i) {
      const double along = lane % 2 == 0 ? 1.0 : -1.0;
      Shot shot;
      shot.name = "air" + std::to_string(100 + shots.size()) + ".png";
      shot.x_in_enu = {along * 8.0 * (i - 0.5 * (photos_of_lane - 1)) + rng.gaussian(0.3),
                       12.0 * (lane - 0.5 * (num_lanes - 1)) + rng.gaussian(0.3),
                       height_m + rng.gaussian(0.3)};
      // Close to straight down, the yaw less the roll is the heading of the picture's top.
      const double heading_rad = (is_fixed ? 0.0 : -0.5 * kPi * along) + rng.gaussian(0.03);
      shot.yaw_rad = rng.uniform(-kPi, kPi);
      shot.pitch_rad = -0.5 * kPi + rng.gaussian(0.03);
      shot.roll_rad = shot.yaw_rad - heading_rad;
      shot.gps_error_m = {rng.gaussian(1.0), rng.gaussian(1.0), rng.gaussian(3.0)};
      shots.push_back(shot);
    }
  }
  return shots;
}

// The photo as a file with EXIF.
inline std::vector<uint8_t> FileOf(const Shot& shot, const GrayImage& image) {
  ExifContent exif = shot.exif;
  if (shot.has_gps && !exif.lat_deg) {
    const Geodetic gps =
        GeodeticFromEcef(EcefFromEnu(PhotoScene::Origin()) * (shot.x_in_enu + shot.gps_error_m));
    exif.lat_deg = gps.lat_deg();
    exif.lon_deg = gps.lon_deg();
    exif.altitude_m = gps.h_m;
    exif.altitude_ref = 2;  // Above the ellipsoid.
    exif.error_m = 1.5;
  }
  if (!exif.focal_35mm) {
    exif.focal_35mm = static_cast<uint16_t>(
        std::lround(36.0 * shot.focal_px / std::max(shot.width_px, shot.height_px)));
  }
  return PngWithExifBlock(EncodePng(image), ExifBlock(exif));
}

inline void WriteBytes(const std::filesystem::path& path, const std::vector<uint8_t>& bytes) {
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

inline void WriteFolder(const PhotoScene& scene, const std::vector<Shot>& shots,
                        const std::filesystem::path& folder) {
  for (const Shot& shot : shots) {
    WriteBytes(folder / shot.name, FileOf(shot, scene.Take(shot)));
  }
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_MAPPING_PHOTO_SCENE_H_
