// Query lists whose features are files of their own.
#ifndef CAIRN_CLI_QUERY_FEATURES_H_
#define CAIRN_CLI_QUERY_FEATURES_H_

#include <string>
#include <vector>

#include "eval/eval_query.h"

namespace cairn {

// Fills the features of queries that have a features_path. Throws Error(kBadInput) naming the file
// if it is not one of features, has none, or is of an image of another size than the camera's.
void ReadQueryFeatures(std::vector<EvalQuery>* queries);

// Writes the list to `path` and the features of each query, without loss, to "<name>.features" in
// the folder "<path without extension>_features" beside it. Sets features_path. Throws Error(kIo).
void WriteQueryListWithFeatures(const std::string& path, std::vector<EvalQuery>* queries);

}  // namespace cairn

#endif  // CAIRN_CLI_QUERY_FEATURES_H_
