#include "fusion/transport/map_transport.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>

#include <atomic>
#include <condition_variable>
#include <latch>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "core/error.h"
#include "core/wire/wire_response.h"
#include "http/server_fixture.h"
#include "street_query.h"
#include "support/canned_server.h"

namespace cairn::fusion {
namespace {

using cairn::testing::CannedServer;
using Clock = std::chrono::steady_clock;

// Collects answers; Wait blocks until there are as many as it asks for.
class Answers {
 public:
  MapTransport::Callback Collect() {
    return [this](Answer answer) {
      const std::lock_guard lock(mutex_);
      answers_.push_back(std::move(answer));
      changed_.notify_all();
    };
  }
  std::vector<Answer> Wait(size_t count) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return answers_.size() >= count; });
    return answers_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Answer> answers_;
};

// Time that passes when the test says so.
class ManualClock {
 public:
  std::function<Clock::time_point()> Now() {
    return [this] { return Clock::time_point(std::chrono::milliseconds(milliseconds_)); };
  }
  void Advance(double seconds) { milliseconds_ += static_cast<int64_t>(1e3 * seconds); }

 private:
  std::atomic<int64_t> milliseconds_ = 1'000'000;
};

MapQuery SmallQuery(int64_t query_id) {
  MapQuery query;
  query.request.query_id = query_id;
  query.request.down_in_cam = {0.0, 1.0, 0.0};
  query.features.descriptors = DescriptorMatrix::Zero(1, 128);
  query.features.keypoints.push_back({10.0f, 10.0f, 1.0f, 0.0f});
  return query;
}

// What a server answers that has no pose.
std::string Miss() { return WireResponseJson({.reason = "NO_COVERAGE"}).dump(); }

MapTransportOptions OptionsFor(const std::string& url, ManualClock* clock) {
  MapTransportOptions options;
  options.url = url;
  options.global_origin = Geodetic::FromDegrees(47.3769, 8.5417, 408.0);
  options.min_interval_s = 0.0;
  options.timeout_ms = 20'000;
  options.now = clock->Now();
  return options;
}

class StreetTransportTest : public cairn::testing::ServerFixture {};

TEST_F(StreetTransportTest, BringsPoseAndMatchesInGlobal) {
  ManualClock clock;
  MapTransportOptions options = OptionsFor(url(), &clock);
  options.global_origin = world_->options().origin;
  Answers answers;
  MapTransport transport(options, answers.Collect());
  MapQuery query = testing::ProjectedMapQueryFrom(Query(), 5, map_path());
  for (int i = 0; i < query.features.size(); ++i) {
    query.track_of_keypoint.push_back(static_cast<uint64_t>(1000 + i));
  }
  ASSERT_EQ(transport.Send(query), SendStatus::kQueued);
  const Answer answer = answers.Wait(1).front();
  ASSERT_TRUE(answer.localized);
  EXPECT_EQ(answer.query_id, 5);
  const Rigid3d cam_from_global = TrueCamFromEcef(kQueryX) * EcefFromEnu(options.global_origin);
  const Rigid3d error = cam_from_global * answer.global_from_cam;
  EXPECT_LT(error.translation.norm(), 0.2);
  EXPECT_LT(LogSo3(error.rotation).norm(), 0.01);
  ASSERT_GT(answer.matches.size(), 20u);
  for (const MapMatch& match : answer.matches) {
    const auto pixel = query.camera.Project(cam_from_global * match.x_in_global);
    ASSERT_TRUE(pixel);
    EXPECT_LT((*pixel - match.pixel).norm(), 15.0);
    ASSERT_TRUE(match.track_id);
    const Keypoint& keypoint = query.features.keypoints[*match.track_id - 1000];
    EXPECT_NEAR(keypoint.x_px, match.pixel.x(), 0.02);
  }
  EXPECT_EQ(transport.counters().num_localized, 1);
}

TEST_F(StreetTransportTest, KeepsItsConnectionForManyQueries) {
  ManualClock clock;
  Answers answers;
  MapTransport transport(OptionsFor(url(), &clock), answers.Collect());
  for (size_t i = 1; i <= 5; ++i) {
    ASSERT_EQ(transport.Send(testing::MapQueryFrom(Query(), static_cast<int64_t>(i))),
              SendStatus::kQueued);
    EXPECT_TRUE(answers.Wait(i).back().localized);
  }
  EXPECT_EQ(transport.counters().num_sent, 5);
}

TEST_F(StreetTransportTest, NoPoseIsNoFailure) {
  ManualClock clock;
  Answers answers;
  MapTransport transport(OptionsFor(url(), &clock), answers.Collect());
  MapQuery query = testing::MapQueryFrom(Query(), 9);
  query.rough_position->position = Geodetic::FromDegrees(10.0, 10.0, 0.0);
  ASSERT_EQ(transport.Send(query), SendStatus::kQueued);
  EXPECT_FALSE(answers.Wait(1).front().localized);
  EXPECT_EQ(transport.counters().num_not_localized, 1);
  EXPECT_EQ(transport.Send(query), SendStatus::kQueued);
}

TEST_F(StreetTransportTest, RefusedFeaturesDoNotStopTheNextQuery) {
  ManualClock clock;
  Answers answers;
  MapTransport transport(OptionsFor(url(), &clock), answers.Collect());
  MapQuery query = testing::ProjectedMapQueryFrom(Query(), 1, map_path());
  query.codec = "another-128-16-9";
  ASSERT_EQ(transport.Send(query), SendStatus::kQueued);
  EXPECT_FALSE(answers.Wait(1).front().localized);
  EXPECT_EQ(transport.counters().num_refused, 1);
  ASSERT_EQ(transport.Send(testing::MapQueryFrom(Query(), 2)), SendStatus::kQueued);
  EXPECT_TRUE(answers.Wait(2).back().localized);
}

// How long Send refuses after the failure that has just been reported, to 10 ms.
double PauseS(MapTransport* transport, ManualClock* clock, int64_t query_id) {
  double pause_s = 0.0;
  while (transport->Send(SmallQuery(query_id)) == SendStatus::kBackingOff) {
    clock->Advance(0.01);
    pause_s += 0.01;
    if (pause_s > 100.0) {
      ADD_FAILURE() << "never opens again";
      break;
    }
  }
  return pause_s;
}

TEST(MapTransport, BacksOffWhileTheServerIsDown) {
  std::string url;
  {
    const CannedServer gone([](const httplib::Request&, httplib::Response&) {});
    url = gone.url();
  }
  ManualClock clock;
  MapTransportOptions options = OptionsFor(url, &clock);
  options.first_backoff_s = 1.0;
  options.max_backoff_s = 6.0;
  Answers answers;
  MapTransport transport(options, answers.Collect());
  ASSERT_EQ(transport.Send(SmallQuery(1)), SendStatus::kQueued);
  const double limits_s[] = {1.0, 2.0, 4.0, 6.0, 6.0};
  for (size_t i = 0; i < std::size(limits_s); ++i) {
    EXPECT_FALSE(answers.Wait(i + 1).back().localized);
    const double pause_s = PauseS(&transport, &clock, static_cast<int64_t>(i) + 2);
    EXPECT_GT(pause_s, 0.5 * limits_s[i] - 0.02);
    EXPECT_LT(pause_s, limits_s[i] + 0.02);
  }
  answers.Wait(6);
  EXPECT_EQ(transport.counters().num_unreachable, 6);
}

TEST(MapTransport, JitterDiffersBetweenDevices) {
  const CannedServer server(
      [](const httplib::Request&, httplib::Response& response) { response.status = 503; });
  double pauses_s[2];
  for (uint64_t seed = 1; seed <= 2; ++seed) {
    ManualClock clock;
    MapTransportOptions options = OptionsFor(server.url(), &clock);
    options.first_backoff_s = 10.0;
    options.seed = seed;
    Answers answers;
    MapTransport transport(options, answers.Collect());
    ASSERT_EQ(transport.Send(SmallQuery(1)), SendStatus::kQueued);
    answers.Wait(1);
    pauses_s[seed - 1] = PauseS(&transport, &clock, 2);
  }
  EXPECT_NE(pauses_s[0], pauses_s[1]);
}

TEST(MapTransport, SuccessEndsTheBackOff) {
  std::atomic<bool> healthy = false;
  const CannedServer server([&](const httplib::Request&, httplib::Response& response) {
    response.status = healthy ? 200 : 503;
    response.set_content(Miss(), "application/json");
  });
  ManualClock clock;
  Answers answers;
  MapTransport transport(OptionsFor(server.url(), &clock), answers.Collect());
  ASSERT_EQ(transport.Send(SmallQuery(1)), SendStatus::kQueued);
  answers.Wait(1);
  EXPECT_EQ(transport.Send(SmallQuery(2)), SendStatus::kBackingOff);
  healthy = true;
  clock.Advance(60.0);
  ASSERT_EQ(transport.Send(SmallQuery(2)), SendStatus::kQueued);
  answers.Wait(2);
  EXPECT_EQ(transport.Send(SmallQuery(3)), SendStatus::kQueued);
  answers.Wait(3);
  EXPECT_EQ(transport.counters().num_not_localized, 2);
}

TEST(MapTransport, SendsTheCellThatTheLastAnswerNamed) {
  std::vector<std::string> cells;
  const CannedServer server([&](const httplib::Request& request, httplib::Response& response) {
    cells.push_back(request.get_header_value("X-Cairn-Cell"));
    response.set_header("X-Cairn-Cell", cells.size() == 1 ? "32N-00388-04390" : "no name");
    response.set_content(Miss(), "application/json");
  });
  ManualClock clock;
  Answers answers;
  MapTransport transport(OptionsFor(server.url(), &clock), answers.Collect());
  for (size_t i = 1; i <= 3; ++i) {
    ASSERT_EQ(transport.Send(SmallQuery(static_cast<int64_t>(i))), SendStatus::kQueued);
    answers.Wait(i);
  }
  EXPECT_THAT(cells, ::testing::ElementsAre("", "32N-00388-04390", "32N-00388-04390"));
}

// The transport after one query to a server that answers so; `key` is its key.
struct Refused {
  std::string authorization;
  MapTransportCounters counters;
  SendStatus at_once, soon, later;  // Of the next queries: without a pause, 20 s and 40 s later.
};
Refused SendTo(int status, const char* retry_after) {
  Refused refused;
  const CannedServer server([&](const httplib::Request& request, httplib::Response& response) {
    refused.authorization = request.get_header_value("Authorization");
    response.status = status;
    response.set_header("Retry-After", retry_after);
  });
  ManualClock clock;
  Answers answers;
  MapTransportOptions options = OptionsFor(server.url(), &clock);
  options.api_key = "cairn_abc";
  MapTransport transport(options, answers.Collect());
  EXPECT_EQ(transport.Send(SmallQuery(1)), SendStatus::kQueued);
  answers.Wait(1);
  refused.counters = transport.counters();
  refused.at_once = transport.Send(SmallQuery(4));
  clock.Advance(20.0);
  refused.soon = transport.Send(SmallQuery(2));
  clock.Advance(20.0);
  refused.later = transport.Send(SmallQuery(3));
  return refused;
}

TEST(MapTransport, SendsItsKeyAndBacksOffIfTheServerDoesNotTakeIt) {
  const Refused refused = SendTo(401, "");
  EXPECT_EQ(refused.authorization, "Bearer cairn_abc");
  EXPECT_EQ(refused.counters.num_unauthorized, 1);
  EXPECT_EQ(refused.counters.num_refused, 1);
  EXPECT_EQ(refused.at_once, SendStatus::kBackingOff);
  EXPECT_EQ(refused.soon, SendStatus::kQueued);
}

TEST(MapTransport, ReturnsWhenTheServerSays) {
  const Refused refused = SendTo(429, "25");
  EXPECT_EQ(refused.counters.num_unauthorized, 0);
  EXPECT_EQ(refused.soon, SendStatus::kBackingOff);
  EXPECT_EQ(refused.later, SendStatus::kQueued);
}

TEST(MapTransport, TakesItsKeyOverNoPlainNetwork) {
  ManualClock clock;
  MapTransportOptions options = OptionsFor("http://192.0.2.1:80", &clock);
  options.api_key = "cairn_abc";
  EXPECT_THROW(MapTransport(options, [](Answer) {}), Error);
}

TEST(MapTransport, SilenceOfTheServerIsATimeout) {
  std::latch done(1);
  const CannedServer server([&](const httplib::Request&, httplib::Response&) { done.wait(); });
  ManualClock clock;
  MapTransportOptions options = OptionsFor(server.url(), &clock);
  options.timeout_ms = 50;
  Answers answers;
  {
    MapTransport transport(options, answers.Collect());
    ASSERT_EQ(transport.Send(SmallQuery(1)), SendStatus::kQueued);
    EXPECT_FALSE(answers.Wait(1).front().localized);
    EXPECT_EQ(transport.counters().num_unreachable, 1);
    EXPECT_EQ(transport.Send(SmallQuery(2)), SendStatus::kBackingOff);
  }
  done.count_down();
}

TEST(MapTransport, GarbageIsNoAnswer) {
  std::atomic<int> next = 0;
  const std::vector<std::string> bodies = {"",
                                           "no json",
                                           "[]",
                                           "{}",
                                           R"({"status":1})",
                                           R"({"status":"LOCALIZED","geopose":null})",
                                           std::string(5000, '[')};
  const CannedServer server([&](const httplib::Request&, httplib::Response& response) {
    response.set_content(bodies[static_cast<size_t>(next++)], "application/json");
  });
  ManualClock clock;
  Answers answers;
  MapTransport transport(OptionsFor(server.url(), &clock), answers.Collect());
  for (size_t i = 0; i < bodies.size(); ++i) {
    clock.Advance(60.0);
    ASSERT_EQ(transport.Send(SmallQuery(static_cast<int64_t>(i))), SendStatus::kQueued);
    EXPECT_FALSE(answers.Wait(i + 1).back().localized) << bodies[i].substr(0, 40);
  }
  EXPECT_EQ(transport.counters().num_garbled, static_cast<int64_t>(bodies.size()));
}

TEST(MapTransport, EndlessAnswersAreBrokenOff) {
  const CannedServer server([](const httplib::Request&, httplib::Response& response) {
    response.set_content(std::string(200'000, ' '), "application/json");
  });
  ManualClock clock;
  MapTransportOptions options = OptionsFor(server.url(), &clock);
  options.max_response_bytes = 10'000;
  Answers answers;
  MapTransport transport(options, answers.Collect());
  ASSERT_EQ(transport.Send(SmallQuery(1)), SendStatus::kQueued);
  EXPECT_FALSE(answers.Wait(1).front().localized);
  EXPECT_EQ(transport.counters().num_garbled, 1);
}

TEST(MapTransport, QueueIsBounded) {
  std::latch go_on(1);
  std::latch asked(1);
  std::atomic<int> num_asked = 0;
  const CannedServer server([&](const httplib::Request&, httplib::Response& response) {
    if (num_asked++ == 0) {
      asked.count_down();
    }
    go_on.wait();
    response.set_content(Miss(), "application/json");
  });
  ManualClock clock;
  MapTransportOptions options = OptionsFor(server.url(), &clock);
  options.max_queued = 2;
  Answers answers;
  MapTransport transport(options, answers.Collect());
  ASSERT_EQ(transport.Send(SmallQuery(1)), SendStatus::kQueued);
  asked.wait();
  EXPECT_EQ(transport.Send(SmallQuery(2)), SendStatus::kQueued);
  EXPECT_EQ(transport.Send(SmallQuery(3)), SendStatus::kQueued);
  EXPECT_EQ(transport.Send(SmallQuery(4)), SendStatus::kQueueFull);
  go_on.count_down();
  const std::vector<Answer> all = answers.Wait(3);
  EXPECT_EQ(all[0].query_id, 1);
  EXPECT_EQ(all[1].query_id, 2);
  EXPECT_EQ(all[2].query_id, 3);
}

TEST(MapTransport, QueriesAreRateLimited) {
  const CannedServer server([](const httplib::Request&, httplib::Response& response) {
    response.set_content(Miss(), "application/json");
  });
  ManualClock clock;
  MapTransportOptions options = OptionsFor(server.url(), &clock);
  options.min_interval_s = 1.0;
  Answers answers;
  MapTransport transport(options, answers.Collect());
  EXPECT_EQ(transport.Send(SmallQuery(1)), SendStatus::kQueued);
  clock.Advance(0.9);
  EXPECT_EQ(transport.Send(SmallQuery(2)), SendStatus::kTooSoon);
  clock.Advance(0.2);
  EXPECT_EQ(transport.Send(SmallQuery(3)), SendStatus::kQueued);
  answers.Wait(2);
}

TEST(MapTransport, FeaturesThatCannotBeSentAreAFailedAnswer) {
  ManualClock clock;
  Answers answers;
  MapTransport transport(OptionsFor("http://127.0.0.1:9", &clock), answers.Collect());
  MapQuery query = SmallQuery(3);
  query.features.keypoints[0].x_px = 1e9f;
  ASSERT_EQ(transport.Send(query), SendStatus::kQueued);
  EXPECT_FALSE(answers.Wait(1).front().localized);
  EXPECT_EQ(transport.counters().num_bad_queries, 1);
  EXPECT_EQ(transport.counters().num_sent, 0);
}

TEST(MapTransport, DestructionAnswersWhatIsUnderWay) {
  std::latch asked(1);
  std::latch done(1);
  std::atomic<int> num_asked = 0;
  const CannedServer server([&](const httplib::Request&, httplib::Response&) {
    if (num_asked++ == 0) {
      asked.count_down();
    }
    done.wait();
  });
  ManualClock clock;
  Answers answers;
  {
    MapTransport transport(OptionsFor(server.url(), &clock), answers.Collect());
    ASSERT_EQ(transport.Send(SmallQuery(1)), SendStatus::kQueued);
    asked.wait();
    ASSERT_EQ(transport.Send(SmallQuery(2)), SendStatus::kQueued);
  }
  EXPECT_EQ(answers.Wait(2).size(), 2u);
  EXPECT_EQ(num_asked, 1);
  done.count_down();
}

TEST(MapTransport, RefusesOptionsWithoutSense) {
  ManualClock clock;
  for (const char* url : {"", "127.0.0.1:8080", "http://", "ftp://a", "http://a/b?c"}) {
    EXPECT_THROW(MapTransport(OptionsFor(url, &clock), [](Answer) {}), Error) << url;
  }
  MapTransportOptions options = OptionsFor("http://127.0.0.1:9", &clock);
  options.max_backoff_s = 0.1;
  EXPECT_THROW(MapTransport(options, [](Answer) {}), Error);
}

}  // namespace
}  // namespace cairn::fusion
