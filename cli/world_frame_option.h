// The options --frame, --origin and --model-frame of verbs that write or read poses.
#ifndef CAIRN_CLI_WORLD_FRAME_OPTION_H_
#define CAIRN_CLI_WORLD_FRAME_OPTION_H_

#include <optional>
#include <string>

#include "cli/batch/world_frame.h"

namespace CLI {
class App;
}  // namespace CLI

namespace cairn {

enum class FrameChoice { kEcef, kEnu };

struct WorldFrameArguments {
  std::optional<FrameChoice> frame;
  std::string origin;     // "lat,lon,h"; empty: that of the map.
  std::string model_dir;  // If not empty, the frame is that of this COLMAP model.
};

// `what` are the things that have the frame, e.g. "The poses of --output".
void AddWorldFrameOptions(CLI::App* command, const std::string& what, FrameChoice by_default,
                          WorldFrameArguments* arguments);

// Adds --frame and --origin of a model that stands on Earth already; without --frame, it does not.
void AddModelFrameOptions(CLI::App* command, WorldFrameArguments* arguments);

// `map` is null if there is only a server. Throws Error(kInvalidArgument) if the arguments do not
// fit each other or need a map that is not there, and as MapOrigin and ModelFrame.
WorldFrame WorldFrameOf(const WorldFrameArguments& arguments, FrameChoice by_default,
                        const MapSnapshot* map);

}  // namespace cairn

#endif  // CAIRN_CLI_WORLD_FRAME_OPTION_H_
