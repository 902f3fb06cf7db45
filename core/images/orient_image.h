// Turns pictures upright.
#ifndef CAIRN_CORE_IMAGES_ORIENT_IMAGE_H_
#define CAIRN_CORE_IMAGES_ORIENT_IMAGE_H_

#include "core/images/gray_image.h"

namespace cairn {

// True if EXIF orientation `orientation` exchanges width and height.
inline bool SwapsSides(int orientation) { return orientation >= 5; }

// Turns the picture as EXIF orientation `orientation` (1 to 8) prescribes: 3 by 180 degrees, 6 by
// 90 clockwise, 8 by 90 counterclockwise. 2, 4, 5 and 7 also mirror the picture.
GrayImage OrientImage(GrayImage stored, int orientation);

}  // namespace cairn

#endif  // CAIRN_CORE_IMAGES_ORIENT_IMAGE_H_
