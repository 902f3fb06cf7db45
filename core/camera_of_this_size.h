// Recognizes the parameters of a camera that belong to another size of the picture.
#ifndef CAIRN_CORE_CAMERA_OF_THIS_SIZE_H_
#define CAIRN_CORE_CAMERA_OF_THIS_SIZE_H_

#include <optional>

#include "core/camera.h"

namespace cairn {

// People send a photo at half its size, or upright, with the parameters that its camera has at full
// size, or lying. The principal point tells, since that of a whole picture is near the middle: it
// then lies on the diagonal through the middle, or on its mirror image. Returns the camera whose
// parameters are scaled or turned so that its principal point is near the middle. Nothing if it is
// near the middle as stated, or elsewhere. A picture that was cropped may have such a principal
// point, too, so which of the two is right, only matches with the map tell.
std::optional<Camera> CameraOfThisSize(const Camera& stated);

// True if `other` has the principal point of `stated` with x and y exchanged, as CameraOfThisSize
// turns it.
bool HasAxesExchanged(const Camera& stated, const Camera& other);

}  // namespace cairn

#endif  // CAIRN_CORE_CAMERA_OF_THIS_SIZE_H_
