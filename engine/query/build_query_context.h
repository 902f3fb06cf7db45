// Computes the data of a query that all stages need.
#ifndef CAIRN_ENGINE_QUERY_BUILD_QUERY_CONTEXT_H_
#define CAIRN_ENGINE_QUERY_BUILD_QUERY_CONTEXT_H_

#include "engine/query/localize_query.h"
#include "engine/query/query_context.h"
#include "storage/codebook/descriptor_codec.h"

namespace cairn {

// Projects the descriptors, unprojects the keypoints, rectifies orientations and levels the camera.
// Throws Error(kBadInput) if the descriptors do not match the codebook: they have another dimension
// or were projected with the codebook of another map.
QueryContext BuildQueryContext(const LocalizeQuery& query, const DescriptorCodec& codec,
                               const SearchRegion& region);

// Returns the context of the same query in another region of the same anchor.
QueryContext WithRegion(QueryContext context, const SearchRegion& region);

// Returns the context of the same query as if another camera of the same image size had taken it.
// The query must not be a rig's.
QueryContext WithCamera(QueryContext context, const Camera& camera);

// Returns the context of the same query without its gravity.
QueryContext WithoutGravity(QueryContext context);

}  // namespace cairn

#endif  // CAIRN_ENGINE_QUERY_BUILD_QUERY_CONTEXT_H_
