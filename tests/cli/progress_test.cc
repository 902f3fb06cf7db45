#include "cli/progress.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>

namespace cairn {
namespace {

// A progress whose time the test tells.
class ShownProgress {
 public:
  explicit ShownProgress(ProgressMode mode) : progress_(mode, [this] { return now_; }) {}

  void UpdateAt(double time_s, const std::string& phase, int done, int total) {
    now_ = std::chrono::steady_clock::time_point(
        std::chrono::milliseconds(static_cast<int64_t>(1000.0 * time_s)));
    progress_.Update(phase, done, total);
  }

 private:
  std::chrono::steady_clock::time_point now_;
  Progress progress_;
};

// What updates write to stderr.
std::string Shown(ProgressMode mode, const std::function<void(ShownProgress*)>& update) {
  ::testing::internal::CaptureStderr();
  {
    ShownProgress progress(mode);
    update(&progress);
  }
  return ::testing::internal::GetCapturedStderr();
}

TEST(Progress, TellsTheTimeLeftOncePhasesTakeTenSeconds) {
  EXPECT_EQ(Shown(ProgressMode::kPlain,
                  [](ShownProgress* progress) {
                    progress->UpdateAt(100.0, "growth", 0, 100);
                    progress->UpdateAt(103.0, "growth", 5, 100);
                    progress->UpdateAt(112.0, "growth", 20, 100);
                    progress->UpdateAt(400.0, "growth", 60, 100);
                    progress->UpdateAt(401.0, "growth", 100, 100);
                    progress->UpdateAt(450.0, "growth", 100, 100);
                  }),
            "growth: 0/100\n"
            "growth: 20/100, 48 s left\n"
            "growth: 60/100, 3 min left\n"
            "growth: 100/100\n");
}

TEST(Progress, CountsFromWhatWasDoneAtTheStart) {
  EXPECT_EQ(Shown(ProgressMode::kJson,
                  [](ShownProgress* progress) {
                    progress->UpdateAt(0.0, "features", 50, 100);
                    progress->UpdateAt(20.0, "features", 75, 100);
                  }),
            "{\"phase\":\"features\",\"done\":50,\"total\":100}\n"
            "{\"phase\":\"features\",\"done\":75,\"total\":100,\"secondsLeft\":20.0}\n");
}

TEST(Progress, ShowsStepsOfAPhaseThatTakeLong) {
  EXPECT_EQ(Shown(ProgressMode::kPlain,
                  [](ShownProgress* progress) {
                    progress->UpdateAt(0.0, "growth", 0, 100);
                    progress->UpdateAt(12.0, "growth", 40, 100);
                    progress->UpdateAt(13.0, "growth: adjustment", 0, 50);
                    progress->UpdateAt(33.0, "growth: adjustment", 25, 50);
                    progress->UpdateAt(34.0, "growth", 41, 100);
                    progress->UpdateAt(50.0, "growth: adjustment", 0, 50);
                    progress->UpdateAt(50.9, "growth: adjustment", 50, 50);
                    progress->UpdateAt(51.0, "growth", 100, 100);
                  }),
            "growth: 0/100\n"
            "growth: 40/100, 18 s left\n"
            "growth: adjustment: 25/50, 20 s left\n"
            "growth: 100/100\n");
}

TEST(Progress, AStepThatBeginsAgainCountsAgain) {
  EXPECT_EQ(Shown(ProgressMode::kPlain,
                  [](ShownProgress* progress) {
                    progress->UpdateAt(0.0, "growth", 0, 100);
                    progress->UpdateAt(1.0, "growth: adjustment", 0, 50);
                    progress->UpdateAt(21.0, "growth: adjustment", 40, 50);
                    progress->UpdateAt(30.0, "growth: adjustment", 0, 50);
                    progress->UpdateAt(50.0, "growth: adjustment", 20, 50);
                  }),
            "growth: 0/100\n"
            "growth: adjustment: 40/50, 5 s left\n"
            "growth: adjustment: 20/50, 30 s left\n");
}

TEST(Progress, RedrawsABarAndEndsItsLine) {
  const std::string shown = Shown(ProgressMode::kBar, [](ShownProgress* progress) {
    progress->UpdateAt(0.0, "tiles", 0, 2);
    progress->UpdateAt(0.05, "tiles", 1, 2);  // Within a tenth of a second.
    progress->UpdateAt(0.2, "tiles", 1, 2);
  });
  EXPECT_EQ(shown,
            "\r\033[Ktiles          [................................] 0/2"
            "\r\033[Ktiles          [################................] 1/2\n");
}

}  // namespace
}  // namespace cairn
