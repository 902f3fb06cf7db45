-- A Cairn map, format version 1. docs/formats/map_v1.md explains each table.
--
-- This file creates the tables that GeoPackage 1.3 requires, then the private tables (all STRICT,
-- with the prefix cairn_), then the two layers that QGIS and GDAL show. MapStore::Create runs this
-- file and views.sql in one transaction. Angles are degrees (WGS84), heights are meters above the
-- ellipsoid.

PRAGMA application_id = 0x47504B47;  -- 'GPKG'
PRAGMA user_version = 10300;         -- GeoPackage 1.3.0

-- ---------------------------------------------------------------------------------------------------
-- GeoPackage core
-- ---------------------------------------------------------------------------------------------------

CREATE TABLE gpkg_spatial_ref_sys (
  srs_name                 TEXT    NOT NULL,
  srs_id                   INTEGER NOT NULL PRIMARY KEY,
  organization             TEXT    NOT NULL,
  organization_coordsys_id INTEGER NOT NULL,
  definition               TEXT    NOT NULL,
  description              TEXT
);

INSERT INTO gpkg_spatial_ref_sys VALUES
  ('Undefined cartesian SRS', -1, 'NONE', -1, 'undefined',
   'undefined cartesian coordinate reference system'),
  ('Undefined geographic SRS', 0, 'NONE', 0, 'undefined',
   'undefined geographic coordinate reference system'),
  ('WGS 84 geodetic', 4326, 'EPSG', 4326,
   'GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563,'
   || 'AUTHORITY["EPSG","7030"]],AUTHORITY["EPSG","6326"]],PRIMEM["Greenwich",0,'
   || 'AUTHORITY["EPSG","8901"]],UNIT["degree",0.0174532925199433,AUTHORITY["EPSG","9122"]],'
   || 'AXIS["Latitude",NORTH],AXIS["Longitude",EAST],AUTHORITY["EPSG","4326"]]',
   'longitude and latitude in degrees on the WGS 84 ellipsoid');

CREATE TABLE gpkg_contents (
  table_name  TEXT     NOT NULL PRIMARY KEY,
  data_type   TEXT     NOT NULL,
  identifier  TEXT     UNIQUE,
  description TEXT     DEFAULT '',
  -- GeoPackage validators compare this text exactly, blanks included.
  last_change DATETIME NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ','now')),
  min_x       DOUBLE,
  min_y       DOUBLE,
  max_x       DOUBLE,
  max_y       DOUBLE,
  srs_id      INTEGER,
  CONSTRAINT fk_gc_r_srs_id FOREIGN KEY (srs_id) REFERENCES gpkg_spatial_ref_sys (srs_id)
);

CREATE TABLE gpkg_geometry_columns (
  table_name         TEXT    NOT NULL,
  column_name        TEXT    NOT NULL,
  geometry_type_name TEXT    NOT NULL,
  srs_id             INTEGER NOT NULL,
  z                  TINYINT NOT NULL,
  m                  TINYINT NOT NULL,
  CONSTRAINT pk_geom_cols PRIMARY KEY (table_name, column_name),
  CONSTRAINT uk_gc_table_name UNIQUE (table_name),
  CONSTRAINT fk_gc_tn FOREIGN KEY (table_name) REFERENCES gpkg_contents (table_name),
  CONSTRAINT fk_gc_srs FOREIGN KEY (srs_id) REFERENCES gpkg_spatial_ref_sys (srs_id)
);

CREATE TABLE gpkg_extensions (
  table_name     TEXT,
  column_name    TEXT,
  extension_name TEXT NOT NULL,
  definition     TEXT NOT NULL,
  scope          TEXT NOT NULL,
  CONSTRAINT ge_tce UNIQUE (table_name, column_name, extension_name)
);

-- ---------------------------------------------------------------------------------------------------
-- The private tables
-- ---------------------------------------------------------------------------------------------------

-- One row. A program can read the map if it reads format oldest_reader_version or a later one.
CREATE TABLE cairn_map (
  map_id                INTEGER NOT NULL PRIMARY KEY CHECK (map_id = 1),
  format_version        INTEGER NOT NULL CHECK (format_version >= 1),
  oldest_reader_version INTEGER NOT NULL CHECK (oldest_reader_version BETWEEN 1 AND format_version),
  created_at            TEXT    NOT NULL,  -- UTC, RFC 3339, here and below.
  next_landmark_id      INTEGER NOT NULL CHECK (next_landmark_id >= 1),
  -- The codebook for new sessions; NULL if the map has none.
  codebook_id           INTEGER REFERENCES cairn_codebooks (codebook_id)
) STRICT;

-- One row per published update, unless the update was pruned. The largest version is the map's
-- version; version 1 is the empty map. Counts and bounds describe the whole map as of the version.
CREATE TABLE cairn_versions (
  version         INTEGER NOT NULL PRIMARY KEY CHECK (version >= 1),
  created_at      TEXT    NOT NULL,
  author          TEXT    NOT NULL,  -- The login name of the publisher.
  kind            TEXT    NOT NULL,  -- 'ingest', 'rollback', ...
  session         TEXT    NOT NULL,  -- The name of the session concerned, or ''.
  summary         TEXT    NOT NULL,  -- For people.
  codebook_id     INTEGER REFERENCES cairn_codebooks (codebook_id),
  num_sessions    INTEGER NOT NULL CHECK (num_sessions >= 0),
  num_keyframes   INTEGER NOT NULL CHECK (num_keyframes >= 0),
  num_tiles       INTEGER NOT NULL CHECK (num_tiles >= 0),
  num_landmarks   INTEGER NOT NULL CHECK (num_landmarks >= 0),
  num_descriptors INTEGER NOT NULL CHECK (num_descriptors >= 0),
  payload_bytes   INTEGER NOT NULL CHECK (payload_bytes >= 0),
  south_deg       REAL,              -- Of the squares; NULL without any; west > east if the box
  west_deg        REAL,              -- crosses the antimeridian.
  north_deg       REAL,
  east_deg        REAL
) STRICT;

-- The tables of sessions, tiles and keyframes hold the latest version. `since` is the version that
-- added a row. When a later version removes the row, the row moves to the table cairn_past_*, and
-- `until` is that later version.

-- One row per ingested reconstruction.
CREATE TABLE cairn_sessions (
  session_id               INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
  name                     TEXT    NOT NULL UNIQUE CHECK (name <> ''),
  source                   TEXT    NOT NULL,
  created_at               TEXT    NOT NULL,
  recorded_at              TEXT    NOT NULL,  -- When its photos were taken.
  content_digest           TEXT    NOT NULL,  -- Of what was ingested: hexadecimal, may be empty.
  num_images               INTEGER NOT NULL CHECK (num_images >= 0),
  num_landmarks            INTEGER NOT NULL CHECK (num_landmarks >= 0),
  georef_median_residual_m REAL    NOT NULL,
  since                    INTEGER NOT NULL
) STRICT;

CREATE TABLE cairn_past_sessions (
  session_id               INTEGER NOT NULL,
  since                    INTEGER NOT NULL,
  until                    INTEGER NOT NULL CHECK (until > since),
  name                     TEXT    NOT NULL,
  source                   TEXT    NOT NULL,
  created_at               TEXT    NOT NULL,
  recorded_at              TEXT    NOT NULL,
  content_digest           TEXT    NOT NULL,
  num_images               INTEGER NOT NULL,
  num_landmarks            INTEGER NOT NULL,
  georef_median_residual_m REAL    NOT NULL,
  PRIMARY KEY (session_id, since)
) STRICT, WITHOUT ROWID;

-- Codebooks, encoded as docs/formats/codebook_v1.md describes. Digests here and below are the
-- hexadecimal XXH3-128 hash of the bytes.
CREATE TABLE cairn_codebooks (
  codebook_id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
  created_at  TEXT    NOT NULL,
  digest      TEXT    NOT NULL UNIQUE CHECK (length(digest) = 32),
  bytes       BLOB    NOT NULL
) STRICT;

-- Intrinsics without repetition. params is a JSON array in COLMAP's parameter order.
CREATE TABLE cairn_cameras (
  camera_id INTEGER NOT NULL PRIMARY KEY,
  model     TEXT    NOT NULL,
  width_px  INTEGER NOT NULL CHECK (width_px > 0),
  height_px INTEGER NOT NULL CHECK (height_px > 0),
  params    TEXT    NOT NULL,
  UNIQUE (model, width_px, height_px, params)
) STRICT;

-- Encoded tiles, see docs/formats/tile_v1.md; equal bytes have one row. A rowid table, so that blobs
-- can be read incrementally. A payload never changes and its id is never reused, because payload ids
-- are keys of caches.
CREATE TABLE cairn_payloads (
  payload_id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
  digest     TEXT    NOT NULL UNIQUE CHECK (length(digest) = 32),
  bytes      BLOB    NOT NULL
) STRICT;

-- The engine's data of a tile, in addition to the attributes of its coverage feature. landmarks_*
-- is the box around the landmarks, which can reach far outside the square; west > east if the box
-- crosses the antimeridian.
CREATE TABLE cairn_tiles (
  tile_id             INTEGER NOT NULL PRIMARY KEY REFERENCES coverage (tile_id),
  payload_id          INTEGER NOT NULL REFERENCES cairn_payloads (payload_id),
  codebook_id         INTEGER NOT NULL REFERENCES cairn_codebooks (codebook_id),
  landmarks_south_deg REAL    NOT NULL,
  landmarks_west_deg  REAL    NOT NULL,
  landmarks_north_deg REAL    NOT NULL,
  landmarks_east_deg  REAL    NOT NULL,
  since               INTEGER NOT NULL
) STRICT;

CREATE INDEX cairn_tiles_by_payload ON cairn_tiles (payload_id);
CREATE INDEX cairn_tiles_by_since ON cairn_tiles (since);

-- The columns of cairn_tiles and of coverage, but for the geometry.
CREATE TABLE cairn_past_tiles (
  tile_id             INTEGER NOT NULL,
  since               INTEGER NOT NULL,
  until               INTEGER NOT NULL CHECK (until > since),
  tile                TEXT    NOT NULL,
  payload_id          INTEGER NOT NULL REFERENCES cairn_payloads (payload_id),
  codebook_id         INTEGER NOT NULL REFERENCES cairn_codebooks (codebook_id),
  num_landmarks       INTEGER NOT NULL,
  num_descriptors     INTEGER NOT NULL,
  num_keyframes       INTEGER NOT NULL,
  num_bytes           INTEGER NOT NULL,
  min_h_m             REAL    NOT NULL,
  max_h_m             REAL    NOT NULL,
  landmarks_south_deg REAL    NOT NULL,
  landmarks_west_deg  REAL    NOT NULL,
  landmarks_north_deg REAL    NOT NULL,
  landmarks_east_deg  REAL    NOT NULL,
  PRIMARY KEY (tile_id, since)
) STRICT, WITHOUT ROWID;

CREATE INDEX cairn_past_tiles_by_payload ON cairn_past_tiles (payload_id);
CREATE INDEX cairn_past_tiles_by_until ON cairn_past_tiles (until);

-- The engine's data of a keyframe, in addition to the attributes of its feature: cam_from_ecef as a
-- Hamilton quaternion and a translation.
CREATE TABLE cairn_keyframe_poses (
  keyframe_id INTEGER NOT NULL PRIMARY KEY REFERENCES keyframes (keyframe_id),
  camera_id   INTEGER NOT NULL REFERENCES cairn_cameras (camera_id),
  qw          REAL    NOT NULL,
  qx          REAL    NOT NULL,
  qy          REAL    NOT NULL,
  qz          REAL    NOT NULL,
  tx_m        REAL    NOT NULL,
  ty_m        REAL    NOT NULL,
  tz_m        REAL    NOT NULL,
  since       INTEGER NOT NULL
) STRICT;

CREATE INDEX cairn_keyframe_poses_by_camera ON cairn_keyframe_poses (camera_id);

-- The columns of cairn_keyframe_poses and of keyframes, but for what follows from the pose.
CREATE TABLE cairn_past_keyframes (
  keyframe_id INTEGER NOT NULL,
  since       INTEGER NOT NULL,
  until       INTEGER NOT NULL CHECK (until > since),
  session_id  INTEGER NOT NULL,
  tile_id     INTEGER NOT NULL,
  image_name  TEXT    NOT NULL,
  camera_id   INTEGER NOT NULL,
  qw          REAL    NOT NULL,
  qx          REAL    NOT NULL,
  qy          REAL    NOT NULL,
  qz          REAL    NOT NULL,
  tx_m        REAL    NOT NULL,
  ty_m        REAL    NOT NULL,
  tz_m        REAL    NOT NULL,
  PRIMARY KEY (keyframe_id, since)
) STRICT, WITHOUT ROWID;

-- ---------------------------------------------------------------------------------------------------
-- The layers. GeoPackage's column types (POLYGON, POINT) rule out STRICT.
-- ---------------------------------------------------------------------------------------------------

-- One square per tile. Longitudes of a square on the antimeridian continue past 180.
CREATE TABLE coverage (
  tile_id         INTEGER NOT NULL PRIMARY KEY,  -- Bits as in core/tile_id.h.
  geom            POLYGON NOT NULL,
  tile            TEXT    NOT NULL UNIQUE,       -- "32N-03104-35120".
  num_landmarks   INTEGER NOT NULL,
  num_descriptors INTEGER NOT NULL,
  num_keyframes   INTEGER NOT NULL,
  num_bytes       INTEGER NOT NULL,              -- Of the encoded tile.
  min_h_m         DOUBLE  NOT NULL,              -- Heights of the keyframes.
  max_h_m         DOUBLE  NOT NULL
);

-- One point per mapping image.
CREATE TABLE keyframes (
  keyframe_id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
  geom        POINT   NOT NULL,                  -- With height.
  session_id  INTEGER NOT NULL REFERENCES cairn_sessions (session_id),
  tile_id     INTEGER NOT NULL,                  -- The tile that contains it.
  image_name  TEXT    NOT NULL,
  lat_deg     DOUBLE  NOT NULL,
  lon_deg     DOUBLE  NOT NULL,
  h_m         DOUBLE  NOT NULL,
  heading_deg DOUBLE  NOT NULL                   -- Of the optical axis, clockwise from north.
);

-- The tiles whose content names a session, in this or an earlier version. A session can be in
-- histories of a tile without a keyframe there. Rows stay when content goes; they say where to look.
CREATE TABLE cairn_session_tiles (
  session_id INTEGER NOT NULL,
  tile_id    INTEGER NOT NULL,
  PRIMARY KEY (session_id, tile_id)
) STRICT, WITHOUT ROWID;

CREATE INDEX keyframes_by_session ON keyframes (session_id, tile_id);
CREATE INDEX keyframes_by_tile ON keyframes (tile_id);

INSERT INTO gpkg_contents (table_name, data_type, identifier, description, srs_id) VALUES
  ('coverage', 'features', 'coverage', 'Tiles of the map', 4326),
  ('keyframes', 'features', 'keyframes', 'Positions of the mapping images', 4326),
  ('cairn_sessions', 'attributes', 'sessions', 'Ingested reconstructions', NULL);

INSERT INTO gpkg_geometry_columns VALUES
  ('coverage', 'geom', 'POLYGON', 4326, 0, 0),
  ('keyframes', 'geom', 'POINT', 4326, 1, 0);

INSERT INTO gpkg_extensions VALUES
  ('coverage', 'geom', 'gpkg_rtree_index',
   'http://www.geopackage.org/spec120/#extension_rtree', 'write-only'),
  ('keyframes', 'geom', 'gpkg_rtree_index',
   'http://www.geopackage.org/spec120/#extension_rtree', 'write-only'),
  ('cairn_map', NULL, 'cairn_map', 'docs/formats/map_v1.md', 'read-write'),
  ('cairn_versions', NULL, 'cairn_map', 'docs/formats/map_v1.md', 'read-write'),
  ('cairn_past_sessions', NULL, 'cairn_map', 'docs/formats/map_v1.md', 'read-write'),
  ('cairn_past_tiles', NULL, 'cairn_map', 'docs/formats/map_v1.md', 'read-write'),
  ('cairn_past_keyframes', NULL, 'cairn_map', 'docs/formats/map_v1.md', 'read-write'),
  ('cairn_codebooks', NULL, 'cairn_map', 'docs/formats/map_v1.md', 'read-write'),
  ('cairn_cameras', NULL, 'cairn_map', 'docs/formats/map_v1.md', 'read-write'),
  ('cairn_payloads', NULL, 'cairn_map', 'docs/formats/map_v1.md', 'read-write'),
  ('cairn_tiles', NULL, 'cairn_map', 'docs/formats/map_v1.md', 'read-write'),
  ('cairn_session_tiles', NULL, 'cairn_map', 'docs/formats/map_v1.md', 'read-write'),
  ('cairn_keyframe_poses', NULL, 'cairn_map', 'docs/formats/map_v1.md', 'read-write');

-- The R*Trees of the layers, with the triggers that the GeoPackage extension requires. A program
-- that writes to a layer needs ST_IsEmpty, ST_MinX, ST_MaxX, ST_MinY and ST_MaxY. GDAL, QGIS, Cairn
-- and the cairn_sqlite extension have them.

CREATE VIRTUAL TABLE rtree_coverage_geom USING rtree (id, minx, maxx, miny, maxy);

CREATE TRIGGER rtree_coverage_geom_insert AFTER INSERT ON coverage
  WHEN (NEW.geom NOT NULL AND NOT ST_IsEmpty(NEW.geom))
BEGIN
  INSERT OR REPLACE INTO rtree_coverage_geom VALUES (
    NEW.tile_id, ST_MinX(NEW.geom), ST_MaxX(NEW.geom), ST_MinY(NEW.geom), ST_MaxY(NEW.geom));
END;

CREATE TRIGGER rtree_coverage_geom_update1 AFTER UPDATE OF geom ON coverage
  WHEN OLD.tile_id = NEW.tile_id AND (NEW.geom NOT NULL AND NOT ST_IsEmpty(NEW.geom))
BEGIN
  INSERT OR REPLACE INTO rtree_coverage_geom VALUES (
    NEW.tile_id, ST_MinX(NEW.geom), ST_MaxX(NEW.geom), ST_MinY(NEW.geom), ST_MaxY(NEW.geom));
END;

CREATE TRIGGER rtree_coverage_geom_update2 AFTER UPDATE OF geom ON coverage
  WHEN OLD.tile_id = NEW.tile_id AND (NEW.geom IS NULL OR ST_IsEmpty(NEW.geom))
BEGIN
  DELETE FROM rtree_coverage_geom WHERE id = OLD.tile_id;
END;

CREATE TRIGGER rtree_coverage_geom_update3 AFTER UPDATE ON coverage
  WHEN OLD.tile_id <> NEW.tile_id AND (NEW.geom NOT NULL AND NOT ST_IsEmpty(NEW.geom))
BEGIN
  DELETE FROM rtree_coverage_geom WHERE id = OLD.tile_id;
  INSERT OR REPLACE INTO rtree_coverage_geom VALUES (
    NEW.tile_id, ST_MinX(NEW.geom), ST_MaxX(NEW.geom), ST_MinY(NEW.geom), ST_MaxY(NEW.geom));
END;

CREATE TRIGGER rtree_coverage_geom_update4 AFTER UPDATE ON coverage
  WHEN OLD.tile_id <> NEW.tile_id AND (NEW.geom IS NULL OR ST_IsEmpty(NEW.geom))
BEGIN
  DELETE FROM rtree_coverage_geom WHERE id IN (OLD.tile_id, NEW.tile_id);
END;

CREATE TRIGGER rtree_coverage_geom_delete AFTER DELETE ON coverage
  WHEN OLD.geom NOT NULL
BEGIN
  DELETE FROM rtree_coverage_geom WHERE id = OLD.tile_id;
END;

CREATE VIRTUAL TABLE rtree_keyframes_geom USING rtree (id, minx, maxx, miny, maxy);

CREATE TRIGGER rtree_keyframes_geom_insert AFTER INSERT ON keyframes
  WHEN (NEW.geom NOT NULL AND NOT ST_IsEmpty(NEW.geom))
BEGIN
  INSERT OR REPLACE INTO rtree_keyframes_geom VALUES (
    NEW.keyframe_id, ST_MinX(NEW.geom), ST_MaxX(NEW.geom), ST_MinY(NEW.geom), ST_MaxY(NEW.geom));
END;

CREATE TRIGGER rtree_keyframes_geom_update1 AFTER UPDATE OF geom ON keyframes
  WHEN OLD.keyframe_id = NEW.keyframe_id AND (NEW.geom NOT NULL AND NOT ST_IsEmpty(NEW.geom))
BEGIN
  INSERT OR REPLACE INTO rtree_keyframes_geom VALUES (
    NEW.keyframe_id, ST_MinX(NEW.geom), ST_MaxX(NEW.geom), ST_MinY(NEW.geom), ST_MaxY(NEW.geom));
END;

CREATE TRIGGER rtree_keyframes_geom_update2 AFTER UPDATE OF geom ON keyframes
  WHEN OLD.keyframe_id = NEW.keyframe_id AND (NEW.geom IS NULL OR ST_IsEmpty(NEW.geom))
BEGIN
  DELETE FROM rtree_keyframes_geom WHERE id = OLD.keyframe_id;
END;

CREATE TRIGGER rtree_keyframes_geom_update3 AFTER UPDATE ON keyframes
  WHEN OLD.keyframe_id <> NEW.keyframe_id AND (NEW.geom NOT NULL AND NOT ST_IsEmpty(NEW.geom))
BEGIN
  DELETE FROM rtree_keyframes_geom WHERE id = OLD.keyframe_id;
  INSERT OR REPLACE INTO rtree_keyframes_geom VALUES (
    NEW.keyframe_id, ST_MinX(NEW.geom), ST_MaxX(NEW.geom), ST_MinY(NEW.geom), ST_MaxY(NEW.geom));
END;

CREATE TRIGGER rtree_keyframes_geom_update4 AFTER UPDATE ON keyframes
  WHEN OLD.keyframe_id <> NEW.keyframe_id AND (NEW.geom IS NULL OR ST_IsEmpty(NEW.geom))
BEGIN
  DELETE FROM rtree_keyframes_geom WHERE id IN (OLD.keyframe_id, NEW.keyframe_id);
END;

CREATE TRIGGER rtree_keyframes_geom_delete AFTER DELETE ON keyframes
  WHEN OLD.geom NOT NULL
BEGIN
  DELETE FROM rtree_keyframes_geom WHERE id = OLD.keyframe_id;
END;
