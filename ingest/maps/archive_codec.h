// Archived sessions as bytes: docs/formats/archive_v1.md.
#ifndef CAIRN_INGEST_MAPS_ARCHIVE_CODEC_H_
#define CAIRN_INGEST_MAPS_ARCHIVE_CODEC_H_

#include <cstdint>
#include <functional>
#include <istream>
#include <span>
#include <string>

#include "ingest/maps/archived_session.h"

namespace cairn {

// Takes the bytes of a file in order.
using ByteSink = std::function<void(std::span<const uint8_t>)>;

// Ignores what the manifest says about the reconstruction. Needs memory for one image beside the
// reconstruction. Throws Error(kBadInput) if an image does not fit a block, and what `sink` throws.
void EncodeSession(const ArchiveManifest& manifest, const Reconstruction& reconstruction,
                   const ByteSink& sink);

// Reads the manifest of untrusted bytes, and not what follows. `what` names the bytes in messages.
// Throws Error(kMapDamaged), and Error(kIo) if the system could not read. A read past the end, and
// nothing else, sets the failbit alone.
ArchiveManifest DecodeManifest(std::istream* bytes, const std::string& what);

struct ArchiveLimits {
  uint32_t max_block_bytes = uint32_t{1} << 28;
};

// Reads a whole session of untrusted bytes. The reconstruction is valid. Needs memory for one block
// beside the reconstruction. Throws as DecodeManifest.
ArchivedSession DecodeSession(std::istream* bytes, const std::string& what,
                              const ArchiveLimits& limits = {});

}  // namespace cairn

#endif  // CAIRN_INGEST_MAPS_ARCHIVE_CODEC_H_
