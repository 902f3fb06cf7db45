// Features of queries: from files of their own, and from photos.
#ifndef CAIRN_CLI_QUERY_FEATURES_H_
#define CAIRN_CLI_QUERY_FEATURES_H_

#include <string>
#include <vector>

#include "core/features/feature_extractor.h"
#include "eval/eval_query.h"

namespace cairn {

// Reads the features of queries with a features_path. Throws Error(kBadInput), which names the
// file, if the file does not hold features, holds none, or comes from an image of another size than
// the camera's.
void ReadQueryFeatures(std::vector<EvalQuery>* queries);

// Throws Error(kInvalidArgument) if the query names no photo.
void RequirePhoto(const EvalQuery& query);

// Extracts the features of the query's photo, as it is stored. Throws as RequirePhoto, and
// Error(kBadInput) if the photo cannot be read or has another size than the camera's.
void ExtractQueryFeatures(const FeatureExtractor& extractor, EvalQuery* query);

// Writes the list to `path`, and the features of each query, losslessly, to "<name>.features" in
// the folder "<path without extension>_features" beside the list. Sets features_path. Throws
// Error(kIo).
void WriteQueryListWithFeatures(const std::string& path, std::vector<EvalQuery>* queries);

}  // namespace cairn

#endif  // CAIRN_CLI_QUERY_FEATURES_H_
