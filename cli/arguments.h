// Values that people type on the command line.
#ifndef CAIRN_CLI_ARGUMENTS_H_
#define CAIRN_CLI_ARGUMENTS_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/geodesy.h"

namespace cairn {

// All throw Error(kInvalidArgument) naming `option`.

// "1,2.5,-3": exactly `count` finite numbers, or any number of them if `count` is 0.
std::vector<double> ParseNumbers(const std::string& option, const std::string& text, int count);

// "MODEL,width,height,param,...", COLMAP's names and parameter order, pixels.
Camera ParseCamera(const std::string& option, const std::string& text);

// "lat,lon,h": degrees and metres.
Geodetic ParseGeodetic(const std::string& option, const std::string& text);

// "x,y,z", any length but zero; returned with unit length.
Eigen::Vector3d ParseDirection(const std::string& option, const std::string& text);

}  // namespace cairn

#endif  // CAIRN_CLI_ARGUMENTS_H_
