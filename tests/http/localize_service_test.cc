#include "http/service/localize_service.h"

#include <gtest/gtest.h>

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/parallel_for.h"
#include "core/wire/problem.h"
#include "http/server_fixture.h"

namespace cairn {
namespace {

class HttpLocalizeService : public testing::ServerFixture {
 protected:
  static HttpRequest Request(const std::string& body) {
    HttpRequest request;
    request.method = "POST";
    request.headers = {{"content-type", "application/json"}};
    request.body = body;
    request.arrival = std::chrono::steady_clock::now();
    return request;
  }
  // As the handlers do it.
  static LocalizeService::Answer Localize(LocalizeService* service, const HttpRequest& http,
                                          BodyParser& parse) {
    LocalizeService::Visit visit = service->Receive(http);
    return visit.is_late()
               ? service->AnswerLate(visit)
               : service->Localize(std::move(visit), parse(http.Header("content-type"), http.body,
                                                           service->request_limits()));
  }
  static std::string LongBody(const std::string& options) {
    return "{\"options\":" + options + std::string(size_t{80} << 10, ' ') + "}";
  }
};

// Parsers that stay in their turn until they are let go.
struct Parsing {
  std::mutex mutex;
  std::condition_variable changed;
  int num_waiting = 0;
  bool may_end = false;
};
Parsing parsing;
std::atomic<int> num_parsed{0};

LocalizeRequest ParseWhenAllowed(std::string_view, std::string_view, const RequestLimits&) {
  std::unique_lock<std::mutex> lock(parsing.mutex);
  ++parsing.num_waiting;
  parsing.changed.notify_all();
  parsing.changed.wait(lock, [] { return parsing.may_end; });
  throw HttpError(ProblemCode::kInvalidJson, "it was no JSON after all");
}

LocalizeRequest CountAndRefuse(std::string_view, std::string_view, const RequestLimits&) {
  ++num_parsed;
  throw HttpError(ProblemCode::kInvalidJson, "it was no JSON");
}

TEST_F(HttpLocalizeService, LongJsonIsParsedInItsTurnOrNotAtAll) {
  LocalizeService service(Options());
  const int num_cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  std::vector<std::thread> threads;
  for (int i = 0; i < num_cores; ++i) {
    threads.emplace_back([&] {
      EXPECT_THROW(Localize(&service, Request(LongBody("{}")), ParseWhenAllowed), HttpError);
    });
  }
  {
    std::unique_lock<std::mutex> lock(parsing.mutex);
    parsing.changed.wait(lock, [&] { return parsing.num_waiting == num_cores; });
  }
  const HttpRequest late = Request(LongBody("{\"timeoutMs\":1}"));
  const LocalizeService::Answer answer = Localize(&service, late, CountAndRefuse);
  EXPECT_FALSE(answer.result.localized);
  EXPECT_EQ(answer.result.reason, NotLocalizedReason::kTimeout);
  EXPECT_EQ(num_parsed, 0);
  EXPECT_THROW(Localize(&service, Request("{}"), CountAndRefuse), HttpError);
  EXPECT_EQ(num_parsed, 1);  // Short JSON is refused without waiting.
  {
    const std::lock_guard<std::mutex> lock(parsing.mutex);
    parsing.may_end = true;
  }
  parsing.changed.notify_all();
  for (std::thread& thread : threads) {
    thread.join();
  }
  EXPECT_THROW(Localize(&service, late, CountAndRefuse), HttpError);  // The turns are free.
}

TEST_F(HttpLocalizeService, TooManyWaitingRequestsAreRefused) {
  ServerOptions options = Options();
  options.max_waiting = 1;
  LocalizeService service(options);
  std::vector<std::unique_ptr<FairGate::Turn>> turns;
  for (int i = 0; i < NumCores(); ++i) {
    turns.push_back(service.WaitForTurn(Request("")));
  }
  std::thread waiting([&] { EXPECT_NO_THROW(service.WaitForTurn(Request(""))); });
  while (service.num_waiting() == 0) {
    std::this_thread::yield();
  }
  for (const bool is_query : {true, false}) {
    try {
      if (is_query) {
        Localize(&service, Request(LongBody("{}")), CountAndRefuse);
      } else {
        service.WaitForTurn(Request(""));
      }
      ADD_FAILURE() << "not refused";
    } catch (const HttpError& e) {
      EXPECT_EQ(e.problem(), ProblemCode::kUnavailable);
    }
  }
  turns.clear();
  waiting.join();
}

// A request with a gray picture of 8 x 8 pixels.
constexpr char kWithImage[] =
    R"({"camera":{"model":"SIMPLE_PINHOLE","size":[8,8],"modelParams":[8,4,4]},
        "image":{"format":"GRAY8","data":"AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA=="},
        "options":{"timeoutMs":1000}})";

TEST_F(HttpLocalizeService, TheOperatorLimitsTheTimeOfAQuery) {
  ServerOptions options = Options();
  options.max_timeout_ms = 500;
  LocalizeService service(options);
  HttpRequest request = Request(kWithImage);  // Asks for 1,000 ms.
  request.arrival -= std::chrono::milliseconds(501);
  EXPECT_EQ(Localize(&service, request, ParseLocalizeRequest).result.reason,
            NotLocalizedReason::kTimeout);
}

TEST_F(HttpLocalizeService, ImagesAreNotDecodedAfterTheDeadline) {
  LocalizeService service(Options());
  HttpRequest request = Request(kWithImage);
  request.arrival -= std::chrono::milliseconds(1001);
  EXPECT_EQ(Localize(&service, request, ParseLocalizeRequest).result.reason,
            NotLocalizedReason::kTimeout);
}

TEST_F(HttpLocalizeService, ImagesAreNotDecodedWhenTheServerStops) {
  LocalizeService service(Options());
  EXPECT_EQ(Localize(&service, Request(kWithImage), ParseLocalizeRequest).result.reason,
            NotLocalizedReason::kTooFewFeatures);
  service.BeginStop();
  try {
    Localize(&service, Request(kWithImage), ParseLocalizeRequest);
    FAIL();
  } catch (const HttpError& e) {
    EXPECT_EQ(e.problem(), ProblemCode::kUnavailable);
  }
}

}  // namespace
}  // namespace cairn
