// Values that people type on the command line.
#ifndef CAIRN_CLI_ARGUMENTS_H_
#define CAIRN_CLI_ARGUMENTS_H_

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/geodesy.h"

namespace CLI {
class App;
class Validator;
}  // namespace CLI

namespace cairn {

// For CLI::Option::check: a finite number in [min, max]. CLI11's own checks take "nan".
CLI::Validator NumberWithin(double min, double max);
// The same above 0.
CLI::Validator PositiveNumber();

// --seed, which takes whole numbers that are not negative. CLI11 makes 2^64 - 1 of "-1".
void AddSeedOption(CLI::App* command, uint64_t* seed, const std::string& description);

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
