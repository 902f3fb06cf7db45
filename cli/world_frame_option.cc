#include "cli/world_frame_option.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "cli/arguments.h"
#include "cli/choice_option.h"
#include "core/error.h"

namespace cairn {

namespace {

CLI::Option* AddFrameOption(CLI::App* command, const std::string& description,
                            WorldFrameArguments* arguments) {
  return AddWordOption(
      command, "--frame", {"ecef", "enu"},
      [arguments](const std::string& word) {
        arguments->frame = word == "ecef" ? FrameChoice::kEcef : FrameChoice::kEnu;
      },
      description);
}

CLI::Option* AddOriginOption(CLI::App* command, const std::string& by_default,
                             WorldFrameArguments* arguments) {
  return command
      ->add_option("--origin", arguments->origin,
                   "Origin of the frame enu, degrees and meters above the ellipsoid" + by_default)
      ->type_name("lat,lon,h");
}

}  // namespace

void AddWorldFrameOptions(CLI::App* command, const std::string& what, FrameChoice by_default,
                          WorldFrameArguments* arguments) {
  auto* const frame = AddFrameOption(
      command,
      fmt::format("{}: Earth-centered (WGS84), or east-north-up at --origin. Default: {}", what,
                  by_default == FrameChoice::kEcef ? "ecef; enu with --origin" : "enu"),
      arguments);
  auto* const origin =
      AddOriginOption(command, ". Default: the first keyframe of the map", arguments);
  command
      ->add_option("--model-frame", arguments->model_dir,
                   "Take the frame of this COLMAP model, of which the map has images")
      ->type_name("DIR")
      ->excludes(frame)
      ->excludes(origin);
}

void AddModelFrameOptions(CLI::App* command, WorldFrameArguments* arguments) {
  auto* const frame =
      AddFrameOption(command,
                     "The model stands on Earth already, in meters: Earth-centered (WGS84), or "
                     "east-north-up at --origin",
                     arguments);
  AddOriginOption(command, "", arguments)->needs(frame);
}

WorldFrame WorldFrameOf(const WorldFrameArguments& arguments, FrameChoice by_default,
                        const MapSnapshot* map) {
  if (!arguments.model_dir.empty()) {
    if (map == nullptr) {
      throw Error(ErrorCode::kInvalidArgument, "--model-frame needs the map, not a server");
    }
    return ModelFrame(arguments.model_dir, *map);
  }
  const FrameChoice choice =
      arguments.frame.value_or(arguments.origin.empty() ? by_default : FrameChoice::kEnu);
  if (choice == FrameChoice::kEcef) {
    if (!arguments.origin.empty()) {
      throw Error(ErrorCode::kInvalidArgument, "--origin is for --frame enu, not for ecef");
    }
    return WorldFrame();
  }
  if (!arguments.origin.empty()) {
    return EnuFrame(ParseGeodetic("--origin", arguments.origin));
  }
  if (map == nullptr) {
    throw Error(ErrorCode::kInvalidArgument, "--frame enu with a server needs --origin LAT,LON,H");
  }
  return EnuFrame(MapOrigin(*map));
}

}  // namespace cairn
