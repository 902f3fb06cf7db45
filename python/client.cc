#include "python/client.h"

#include <atomic>
#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/features/sift/sift_extractor.h"
#include "core/images/orient_image.h"
#include "http/client.h"
#include "http/exchange/server_url.h"
#include "python/arguments.h"
#include "python/docs.h"
#include "python/interruptible.h"
#include "python/process_guard.h"
#include "python/query.h"

namespace cairn::python {
namespace {

using Clock = std::chrono::steady_clock;

// One exchange after the other, whatever thread asks.
class Server {
 public:
  explicit Server(ClientOptions options) : options_(std::move(options)) {
    options_.exif_prior = false;  // QueryWithoutFeatures has read it.
    options_.wait = [this](std::chrono::seconds pause) {
      const Clock::time_point end = Clock::now() + pause;
      while (!is_stopped_ && Clock::now() < end) {
        std::this_thread::sleep_for(kSignalPeriod);
      }
    };
    ClientOf(ImageOrientation::kAsSize);  // Finds what is wrong with the options.
  }

  PythonResult Answer(const StatedQuery& stated, const WorkProgress& report) {
    while (!mutex_.try_lock_for(kSignalPeriod)) {
      report("wait", 0, 0);
    }
    const std::lock_guard lock(mutex_, std::adopt_lock);
    SetTurn(&stated);
    PythonResult answer;
    try {
      answer.result = stated.input.features ? AskWithFeatures(stated) : AskWithImages(stated);
    } catch (...) {
      SetTurn(nullptr);
      throw;
    }
    SetTurn(nullptr);
    answer.localize_seconds = answer.result.times.total_seconds;
    return answer;
  }

  // Aborts the exchange under way if it is that of this query, and not of another thread's.
  void Stop(const StatedQuery& stated) {
    const std::lock_guard lock(turn_mutex_);
    if (turn_ == &stated) {
      is_stopped_ = true;
      LocalizeClient* const active = active_;
      if (active != nullptr) {
        active->Stop();
      }
    }
  }

 private:
  // Of the query whose exchange begins, or null at its end.
  void SetTurn(const StatedQuery* stated) {
    const std::lock_guard lock(turn_mutex_);
    turn_ = stated;
    is_stopped_ = false;
  }

  // The clients differ in the pictures that they mean.
  LocalizeClient* ClientOf(ImageOrientation orientation) {
    std::unique_ptr<LocalizeClient>& client = clients_[orientation];
    if (client == nullptr) {
      ClientOptions options = options_;
      options.image_orientation = orientation;
      client = std::make_unique<LocalizeClient>(options);
    }
    active_ = client.get();
    return client.get();
  }

  LocalizeResult AskWithFeatures(const StatedQuery& stated) {
    LentQuery lent;
    FillQuery(stated, SiftExtractor(), "", &lent);
    return ClientOf(ImageOrientation::kAsSize)->LocalizeFeatures(lent.query);
  }

  // Sends the pictures as they are stored, and says which way the camera means them.
  LocalizeResult AskWithImages(const StatedQuery& stated) {
    const auto start = Clock::now();
    std::vector<std::vector<uint8_t>> images = {EncodedImage(stated.input)};
    const ExifInfo exif = ReadExif(images[0]);
    const bool is_turned = WantsTurn(exif, stated.camera ? &stated.camera->camera : nullptr);
    int width_px = exif.width_px, height_px = exif.height_px;
    if (is_turned && SwapsSides(exif.orientation)) {
      std::swap(width_px, height_px);
    }
    LocalizeQuery query = QueryWithoutFeatures(stated, &exif, width_px, height_px);
    for (const RigInput& seen : stated.rig) {
      if (seen.input.features) {
        throw Error(ErrorCode::kInvalidArgument,
                    "rig: a server takes either pictures or features of all cameras");
      }
      images.push_back(EncodedImage(seen.input));
    }
    if (stated.timeout_ms) {
      query.deadline = start + std::chrono::milliseconds(*stated.timeout_ms);
    }
    const ImageOrientation orientation = !stated.rig.empty() ? ImageOrientation::kAsSize
                                         : is_turned         ? ImageOrientation::kUpright
                                                             : ImageOrientation::kStored;
    return ClientOf(orientation)->LocalizeImages(query, images);
  }

  ClientOptions options_;
  std::timed_mutex mutex_;  // Of clients_ and of the exchange.
  std::map<ImageOrientation, std::unique_ptr<LocalizeClient>> clients_;
  std::atomic<LocalizeClient*> active_ = nullptr;
  std::mutex turn_mutex_;
  const StatedQuery* turn_ = nullptr;  // The query under way.
  std::atomic<bool> is_stopped_ = false;
};

class PythonClient {
 public:
  PythonClient(const py::object& url, const py::object& api_key, const py::object& ca_file,
               const py::object& timeout_ms, const py::object& allow_plain_key)
      : url_(TextOf("url", url)),
        server_(Connect(url_, api_key, ca_file, timeout_ms, allow_plain_key)) {}

  PythonResult Localize(const py::object& image, const py::object& camera, const py::object& prior,
                        const py::object& accuracy_m, const py::object& gravity,
                        const py::object& rig, const py::object& timeout_ms,
                        const py::object& exif_prior) const {
    server_.guard().Require("client: this cairn.Client");
    const PythonQuery query =
        QueryOfCall(image, camera, prior, accuracy_m, gravity, rig, timeout_ms, exif_prior);
    const std::shared_ptr<Server> server = server_.get();
    PythonResult answer;
    RunInterruptibly(
        py::none(),
        [&](const WorkProgress& report) { answer = server->Answer(query.stated, report); },
        [&] { server->Stop(query.stated); });
    return answer;
  }

  const std::string& url() const { return url_; }

 private:
  static std::shared_ptr<Server> Connect(const std::string& url, const py::object& api_key,
                                         const py::object& ca_file, const py::object& timeout_ms,
                                         const py::object& allow_plain_key) {
    ClientOptions options;
    options.url = url;
    options.api_key = api_key.is_none() ? "" : TextOf("api_key", api_key);
    options.ca_file = PathOrEmpty("ca_file", ca_file);
    options.timeout_ms = static_cast<int>(IntegerOf("timeout_ms", timeout_ms, 1, 3'600'000));
    options.allow_plain_key = FlagOf("allow_plain_key", allow_plain_key);
    return std::make_shared<Server>(options);
  }

  std::string url_;
  AtHome<Server> server_;
};

}  // namespace

void BindClient(py::module_* module) {
  using py::arg;
  py::class_<PythonClient>(*module, "Client", docs::kClient)
      .def(py::init<const py::object&, const py::object&, const py::object&, const py::object&,
                    const py::object&>(),
           arg("url"), arg("api_key") = py::none(), py::kw_only(), arg("ca_file") = py::none(),
           arg("timeout_ms") = 30'000, arg("allow_plain_key") = false)
      .def("localize", &PythonClient::Localize, arg("image"), arg("camera") = py::none(),
           py::kw_only(), arg("prior") = py::none(), arg("accuracy_m") = 15.0,
           arg("gravity") = py::none(), arg("rig") = py::none(), arg("timeout_ms") = py::none(),
           arg("exif_prior") = true, docs::kClientLocalize)
      .def_property_readonly("url", &PythonClient::url, "The server's URL.");
}

}  // namespace cairn::python
