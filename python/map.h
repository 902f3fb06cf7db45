// cairn.Map: a map that answers queries and shows what is in it.
#ifndef CAIRN_PYTHON_MAP_H_
#define CAIRN_PYTHON_MAP_H_

#include <memory>
#include <string>

#include "core/features/sift/sift_extractor.h"
#include "engine/localizer.h"
#include "python/errors.h"
#include "python/process_guard.h"
#include "python/query.h"

namespace cairn::python {

// What queries need. Safe to use from any thread, without the GIL.
struct OpenedMap {
  Localizer localizer;
  SiftExtractor extractor;
  std::string descriptor_type;  // Empty as long as the map has no codebook.

  PythonResult Answer(const StatedQuery& stated) const;
};

// Needs the GIL.
class PythonMap {
 public:
  // Throws as Localizer::Open and OptionsOf.
  PythonMap(const py::object& path, const py::object& cache_mb, const py::object& options);

  // Throws Error(kConflict) if the map was closed, or opened by another process.
  std::shared_ptr<const OpenedMap> Require() const;
  void Close() { map_.Reset(); }
  bool is_closed() const { return map_.get() == nullptr; }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
  AtHome<const OpenedMap> map_;
};

// The parts of the class, by subject.
void BindMap(py::module_* module);
void BindMapContent(py::class_<PythonMap>* map);
void BindMapBatches(py::module_* module, py::class_<PythonMap>* map);

}  // namespace cairn::python

#endif  // CAIRN_PYTHON_MAP_H_
