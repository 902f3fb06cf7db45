// The values of which a plan and an archive are made, as bytes: texts and descriptors.
// Private to ingest/maps.
#ifndef CAIRN_INGEST_MAPS_STORED_VALUES_H_
#define CAIRN_INGEST_MAPS_STORED_VALUES_H_

#include <cstddef>
#include <string>

#include "core/packed_features.h"
#include "storage/tile/byte_io.h"

namespace cairn::stored {

// The length as 4 bytes, then the text.
void PutText(const std::string& text, ByteWriter* writer);
std::string GetText(ByteReader* reader);

// Row by row, a value in one byte (`as_bytes`; they must have PackedDescriptors::as_bytes) or as a
// float.
void PutDescriptors(const PackedDescriptors& descriptors, bool as_bytes, ByteWriter* writer);
// There must be that many values left; ByteReader throws if not.
PackedDescriptors GetDescriptors(size_t num_rows, size_t dim, bool as_bytes, ByteReader* reader);

}  // namespace cairn::stored

#endif  // CAIRN_INGEST_MAPS_STORED_VALUES_H_
