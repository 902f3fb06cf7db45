#include "cli/open_page.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "cli/npm_folder.h"

namespace cairn::testing {

using ::nlohmann::json;

std::string WhyNoBrowser() {
  const auto [text, code] =
      RunShell("test -x /usr/bin/chromium && /usr/bin/python3 -c 'import selenium'");
  return code == 0 ? "" : "chromium and python3-selenium are not installed " + text;
}

json OpenPage(const json& todo, const TempDir& dir) {
  std::ofstream(dir.File("visits.json")) << todo;
  const auto [text, code] = RunShell("'" CAIRN_SOURCE_DIR "/tests/cli/ui_page/open_page.py' '" +
                                     dir.File("visits.json") + "'");
  EXPECT_EQ(code, 0) << text;
  const json seen = json::parse(text, nullptr, false);
  EXPECT_TRUE(seen.is_object()) << text;
  return seen;
}

}  // namespace cairn::testing
