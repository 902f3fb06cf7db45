#include "python/map.h"

#include <fmt/format.h>

#include <chrono>
#include <utility>

#include "core/error.h"
#include "core/seconds_since.h"
#include "python/arguments.h"
#include "python/docs.h"
#include "python/interruptible.h"

namespace cairn::python {
namespace {

std::shared_ptr<const OpenedMap> OpenMapAt(const std::string& path, const py::object& cache_mb,
                                           const py::object& options_argument) {
  const double megabytes = NumberOf("cache_mb", cache_mb, 1.0, 1e9);
  const CairnOptions options = OptionsOf(options_argument);
  const py::gil_scoped_release release;
  auto map = std::make_shared<OpenedMap>(OpenedMap{
      Localizer::Open(path, options.localizer, static_cast<size_t>(1048576.0 * megabytes)),
      SiftExtractor(options.sift), ""});
  if (const auto codebook = map->localizer.map().Snapshot().CurrentCodebook()) {
    map->descriptor_type = codebook->descriptor_type;
  }
  return map;
}

PythonResult Localize(const PythonMap& map, const PythonQuery& query) {
  const std::shared_ptr<const OpenedMap> opened = map.Require();
  PythonResult answer;
  {
    const py::gil_scoped_release release;
    answer = opened->Answer(query.stated);
  }
  ThrowOnSignal();
  return answer;
}

PythonResult LocalizeImage(const PythonMap& map, const py::object& image, const py::object& camera,
                           const py::object& prior, const py::object& accuracy_m,
                           const py::object& gravity, const py::object& rig,
                           const py::object& timeout_ms, const py::object& exif_prior) {
  return Localize(
      map, QueryOfCall(image, camera, prior, accuracy_m, gravity, rig, timeout_ms, exif_prior));
}

}  // namespace

PythonResult OpenedMap::Answer(const StatedQuery& stated) const {
  PythonResult answer;
  LentQuery lent;
  FillQuery(stated, extractor, descriptor_type, &lent);
  const auto start = std::chrono::steady_clock::now();
  answer.result = localizer.Localize(lent.query);
  answer.localize_seconds = SecondsSince(start);
  answer.decode_seconds = lent.decode_seconds;
  answer.extract_seconds = lent.extract_seconds;
  return answer;
}

PythonMap::PythonMap(const py::object& path, const py::object& cache_mb, const py::object& options)
    : path_(PathOf("path_or_url", path)), map_(OpenMapAt(path_, cache_mb, options)) {}

std::shared_ptr<const OpenedMap> PythonMap::Require() const {
  map_.guard().Require("map: this cairn.Map");
  if (is_closed()) {
    throw Error(ErrorCode::kConflict,
                fmt::format("map: this cairn.Map of {} is closed; open it again", path_));
  }
  return map_.get();
}

void BindMap(py::module_* module) {
  using py::arg;
  py::class_<PythonMap> map(*module, "Map", docs::kMap);
  map.def(py::init<const py::object&, const py::object&, const py::object&>(), arg("path_or_url"),
          arg("cache_mb") = 1024, arg("options") = py::none())
      .def("localize", &LocalizeImage, arg("image"), arg("camera") = py::none(), py::kw_only(),
           arg("prior") = py::none(), arg("accuracy_m") = 15.0, arg("gravity") = py::none(),
           arg("rig") = py::none(), arg("timeout_ms") = py::none(), arg("exif_prior") = true,
           docs::kLocalize)
      .def("close", &PythonMap::Close, docs::kMapClose)
      .def_property_readonly("closed", &PythonMap::is_closed, "Whether close() was called.")
      .def_property_readonly(
          "path", [](const PythonMap& self) { return TextOut(self.path()); }, "The path or URL.")
      .def("__enter__", [](py::object self) { return self; })
      .def("__exit__", [](PythonMap& self, const py::args& /*exception*/) { self.Close(); })
      .def("__repr__", [](const PythonMap& self) {
        return TextOut(
            fmt::format("<cairn.Map {}{}>", self.path(), self.is_closed() ? ", closed" : ""));
      });
  BindMapContent(&map);
  BindMapBatches(module, &map);
}

}  // namespace cairn::python
