// Computes once what every stage needs of a query.
#ifndef CAIRN_ENGINE_QUERY_BUILD_QUERY_CONTEXT_H_
#define CAIRN_ENGINE_QUERY_BUILD_QUERY_CONTEXT_H_

#include "engine/query/localize_query.h"
#include "engine/query/query_context.h"
#include "storage/codebook/descriptor_codec.h"

namespace cairn {

// Projects the descriptors, unprojects the keypoints, rectifies orientations and levels the camera.
// Throws Error(kBadInput) if the descriptors do not fit the codebook: wrong dimension, or projected
// by the codebook of another map.
QueryContext BuildQueryContext(const LocalizeQuery& query, const DescriptorCodec& codec,
                               const SearchRegion& region);

// The context of the same query, which is not of a rig, as another camera of that size saw it.
QueryContext WithCamera(QueryContext context, const Camera& camera);

// The context of the same query without its gravity.
QueryContext WithoutGravity(QueryContext context);

}  // namespace cairn

#endif  // CAIRN_ENGINE_QUERY_BUILD_QUERY_CONTEXT_H_
