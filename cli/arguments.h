// Parsers and checks for values on the command line.
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
class Option;
class Validator;
}  // namespace CLI

namespace cairn {

// For CLI::Option::check: accepts a finite number in [min, max]. CLI11's own checks accept "nan".
CLI::Validator NumberWithin(double min, double max);
// Accepts a finite number above 0.
CLI::Validator PositiveNumber();

// Adds --seed, which accepts whole numbers from 0. CLI11 itself would turn "-1" into 2^64 - 1.
void AddSeedOption(CLI::App* command, uint64_t* seed, const std::string& description);

// Adds --ca, the certificates that a client of `server`, the option of a URL, trusts.
void AddCaOption(CLI::App* command, CLI::Option* server, std::string* ca_file);

// All functions below throw Error(kInvalidArgument), which names `option`. Blanks around numbers do
// not count.

// Parses "1,2.5,-3": exactly `count` finite numbers, or any number of them if `count` is 0.
std::vector<double> ParseNumbers(const std::string& option, const std::string& text, int count);

// Parses "MODEL,width,height,param,...": COLMAP's model names and parameter order, in pixels.
Camera ParseCamera(const std::string& option, const std::string& text);

// Parses "lat,lon,h" in degrees and meters. The error names the numbers that are missing.
Geodetic ParseGeodetic(const std::string& option, const std::string& text);

// The same, but the height may be missing; it is then 0.
Geodetic ParsePlace(const std::string& option, const std::string& text);

// Parses "x,y,z" of any length except zero. Returns a unit vector.
Eigen::Vector3d ParseDirection(const std::string& option, const std::string& text);

}  // namespace cairn

#endif  // CAIRN_CLI_ARGUMENTS_H_
