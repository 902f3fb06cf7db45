#include "mapping/session/add_segment.h"

#include <utility>

namespace cairn {

std::vector<CameraReport> ReportCameras(const Segment& segment,
                                        std::span<const MappingCamera> cameras_as_read) {
  const std::vector<Camera>& cameras = segment.model.cameras;
  std::vector<int> num_photos(cameras.size(), 0);
  for (const ReconImage& image : segment.model.images) {
    ++num_photos[image.camera_idx];
  }
  std::vector<CameraReport> reports;
  for (size_t i = 0; i < cameras.size(); ++i) {
    const MappingCamera& before = cameras_as_read[i];
    if (num_photos[i] > 0) {
      reports.push_back({cameras[i], before.camera.focal_px(), before.source, num_photos[i]});
    }
  }
  return reports;
}

void AppendModel(Reconstruction more, Reconstruction* model) {
  const int first_camera = static_cast<int>(model->cameras.size());
  const int first_image = static_cast<int>(model->images.size());
  model->cameras.insert(model->cameras.end(), more.cameras.begin(), more.cameras.end());
  for (ReconImage& image : more.images) {
    image.camera_idx += first_camera;
    model->images.push_back(std::move(image));
  }
  for (ReconLandmark& landmark : more.landmarks) {
    for (ReconObservation& seen : landmark.observations) {
      seen.image_idx += first_image;
    }
    model->landmarks.push_back(std::move(landmark));
  }
}

void AddSegment(const Segment& segment, const Sim3d& ecef_from_segment, int number,
                MappedPhotos* mapped, Reconstruction* model) {
  const Sim3d world_from_segment = mapped->ecef_from_world.Inverse() * ecef_from_segment;
  Reconstruction part = segment.model;
  for (size_t i = 0; i < part.images.size(); ++i) {
    ReconImage& image = part.images[i];
    image.cam_from_world = CamFromTarget(image.cam_from_world, world_from_segment);
    const int photo = segment.photo_of_image[i];
    mapped->center_of_photo[photo] = image.cam_from_world.Inverse().translation;
    mapped->photo_of_image.push_back(photo);
    mapped->segment_of_image.push_back(number);
  }
  for (ReconLandmark& landmark : part.landmarks) {
    landmark.x_in_world = world_from_segment * landmark.x_in_world;
  }
  AppendModel(std::move(part), model);
  mapped->num_mapped = static_cast<int>(model->images.size());
}

}  // namespace cairn
