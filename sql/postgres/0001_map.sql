-- A Cairn map in PostgreSQL with PostGIS, migration 1. The tables and columns are those of an SQLite
-- map (sql/schema.sql), so the same queries read both; docs/formats/map_v1.md explains each. Geometry
-- is PostGIS's. QGIS shows the layers `coverage` and `keyframes`.
--
-- Angles are degrees (WGS84), heights are meters above the ellipsoid. A role needs CREATE on the
-- database. Run by `cairn init URL` in one transaction.

CREATE SCHEMA cairn;
SET LOCAL search_path = cairn, public;

CREATE TABLE cairn_migrations (
  migration  bigint     NOT NULL PRIMARY KEY,
  name       text        NOT NULL,
  applied_at timestamptz NOT NULL DEFAULT now()
);

CREATE TABLE cairn_codebooks (
  codebook_id bigint NOT NULL PRIMARY KEY,
  created_at  text    NOT NULL,
  digest      text    NOT NULL UNIQUE CHECK (length(digest) = 32),
  bytes       bytea    NOT NULL
);

CREATE TABLE cairn_map (
  map_id                bigint NOT NULL PRIMARY KEY CHECK (map_id = 1),
  format_version        bigint NOT NULL CHECK (format_version >= 1),
  oldest_reader_version bigint NOT NULL CHECK (oldest_reader_version BETWEEN 1 AND format_version),
  created_at            text    NOT NULL,  -- UTC, RFC 3339, here and below.
  next_landmark_id      bigint NOT NULL CHECK (next_landmark_id >= 1),
  -- The codebook for new sessions; NULL if the map has none.
  codebook_id           bigint REFERENCES cairn_codebooks (codebook_id)
);

CREATE TABLE cairn_versions (
  version         bigint NOT NULL PRIMARY KEY CHECK (version >= 1),
  created_at      text    NOT NULL,
  author          text    NOT NULL,  -- The login name of the publisher.
  kind            text    NOT NULL,  -- 'ingest', 'rollback', ...
  session         text    NOT NULL,  -- The name of the session concerned, or ''.
  summary         text    NOT NULL,  -- For people.
  codebook_id     bigint REFERENCES cairn_codebooks (codebook_id),
  num_sessions    bigint NOT NULL CHECK (num_sessions >= 0),
  num_keyframes   bigint NOT NULL CHECK (num_keyframes >= 0),
  num_tiles       bigint NOT NULL CHECK (num_tiles >= 0),
  num_landmarks   bigint NOT NULL CHECK (num_landmarks >= 0),
  num_descriptors bigint NOT NULL CHECK (num_descriptors >= 0),
  payload_bytes   bigint NOT NULL CHECK (payload_bytes >= 0),
  south_deg       double precision,              -- Of the squares; NULL without any; west > east if the box
  west_deg        double precision,              -- crosses the antimeridian.
  north_deg       double precision,
  east_deg        double precision
);

CREATE TABLE cairn_sessions (
  session_id               bigint NOT NULL PRIMARY KEY,
  name                     text    NOT NULL UNIQUE CHECK (name <> ''),
  source                   text    NOT NULL,
  created_at               text    NOT NULL,
  recorded_at              text    NOT NULL,  -- When its photos were taken.
  content_digest           text    NOT NULL,  -- Of what was ingested: hexadecimal, may be empty.
  num_images               bigint NOT NULL CHECK (num_images >= 0),
  num_landmarks            bigint NOT NULL CHECK (num_landmarks >= 0),
  georef_median_residual_m double precision    NOT NULL,
  since                    bigint NOT NULL
);

CREATE TABLE cairn_past_sessions (
  session_id               bigint NOT NULL,
  since                    bigint NOT NULL,
  until                    bigint NOT NULL CHECK (until > since),
  name                     text    NOT NULL,
  source                   text    NOT NULL,
  created_at               text    NOT NULL,
  recorded_at              text    NOT NULL,
  content_digest           text    NOT NULL,
  num_images               bigint NOT NULL,
  num_landmarks            bigint NOT NULL,
  georef_median_residual_m double precision    NOT NULL,
  PRIMARY KEY (session_id, since)
);

CREATE TABLE cairn_cameras (
  camera_id bigint NOT NULL PRIMARY KEY,
  model     text    NOT NULL,
  width_px  bigint NOT NULL CHECK (width_px > 0),
  height_px bigint NOT NULL CHECK (height_px > 0),
  params    text    NOT NULL,
  UNIQUE (model, width_px, height_px, params)
);

CREATE TABLE cairn_payloads (
  payload_id bigint NOT NULL PRIMARY KEY,
  digest     text    NOT NULL UNIQUE CHECK (length(digest) = 32),
  bytes      bytea    NOT NULL
);

CREATE TABLE coverage (
  tile_id         bigint NOT NULL PRIMARY KEY,  -- Bits as in core/tile_id.h.
  geom            geometry(Polygon, 4326) NOT NULL,
  tile            text    NOT NULL UNIQUE,       -- "32N-03104-35120".
  num_landmarks   bigint NOT NULL,
  num_descriptors bigint NOT NULL,
  num_keyframes   bigint NOT NULL,
  num_bytes       bigint NOT NULL,              -- Of the encoded tile.
  min_h_m         double precision  NOT NULL,              -- Heights of the keyframes.
  max_h_m         double precision  NOT NULL
);

CREATE TABLE cairn_tiles (
  tile_id             bigint NOT NULL PRIMARY KEY REFERENCES coverage (tile_id),
  payload_id          bigint NOT NULL REFERENCES cairn_payloads (payload_id),
  codebook_id         bigint NOT NULL REFERENCES cairn_codebooks (codebook_id),
  landmarks_south_deg double precision    NOT NULL,
  landmarks_west_deg  double precision    NOT NULL,
  landmarks_north_deg double precision    NOT NULL,
  landmarks_east_deg  double precision    NOT NULL,
  since               bigint NOT NULL
);

CREATE TABLE cairn_past_tiles (
  tile_id             bigint NOT NULL,
  since               bigint NOT NULL,
  until               bigint NOT NULL CHECK (until > since),
  tile                text    NOT NULL,
  payload_id          bigint NOT NULL REFERENCES cairn_payloads (payload_id),
  codebook_id         bigint NOT NULL REFERENCES cairn_codebooks (codebook_id),
  num_landmarks       bigint NOT NULL,
  num_descriptors     bigint NOT NULL,
  num_keyframes       bigint NOT NULL,
  num_bytes           bigint NOT NULL,
  min_h_m             double precision    NOT NULL,
  max_h_m             double precision    NOT NULL,
  landmarks_south_deg double precision    NOT NULL,
  landmarks_west_deg  double precision    NOT NULL,
  landmarks_north_deg double precision    NOT NULL,
  landmarks_east_deg  double precision    NOT NULL,
  PRIMARY KEY (tile_id, since)
);

CREATE TABLE keyframes (
  keyframe_id bigint NOT NULL PRIMARY KEY,
  geom        geometry(PointZ, 4326) NOT NULL,                  -- With height.
  session_id  bigint NOT NULL REFERENCES cairn_sessions (session_id),
  tile_id     bigint NOT NULL,                  -- The tile that contains it.
  image_name  text    NOT NULL,
  lat_deg     double precision  NOT NULL,
  lon_deg     double precision  NOT NULL,
  h_m         double precision  NOT NULL,
  heading_deg double precision  NOT NULL                   -- Of the optical axis, clockwise from north.
);

CREATE TABLE cairn_keyframe_poses (
  keyframe_id bigint NOT NULL PRIMARY KEY REFERENCES keyframes (keyframe_id),
  camera_id   bigint NOT NULL REFERENCES cairn_cameras (camera_id),
  qw          double precision    NOT NULL,
  qx          double precision    NOT NULL,
  qy          double precision    NOT NULL,
  qz          double precision    NOT NULL,
  tx_m        double precision    NOT NULL,
  ty_m        double precision    NOT NULL,
  tz_m        double precision    NOT NULL,
  since       bigint NOT NULL
);

CREATE TABLE cairn_past_keyframes (
  keyframe_id bigint NOT NULL,
  since       bigint NOT NULL,
  until       bigint NOT NULL CHECK (until > since),
  session_id  bigint NOT NULL,
  tile_id     bigint NOT NULL,
  image_name  text    NOT NULL,
  camera_id   bigint NOT NULL,
  qw          double precision    NOT NULL,
  qx          double precision    NOT NULL,
  qy          double precision    NOT NULL,
  qz          double precision    NOT NULL,
  tx_m        double precision    NOT NULL,
  ty_m        double precision    NOT NULL,
  tz_m        double precision    NOT NULL,
  PRIMARY KEY (keyframe_id, since)
);

CREATE TABLE cairn_session_tiles (
  session_id bigint NOT NULL,
  tile_id    bigint NOT NULL,
  PRIMARY KEY (session_id, tile_id)
);

CREATE INDEX cairn_tiles_by_payload ON cairn_tiles (payload_id);
CREATE INDEX cairn_tiles_by_since ON cairn_tiles (since);
CREATE INDEX cairn_past_tiles_by_payload ON cairn_past_tiles (payload_id);
CREATE INDEX cairn_past_tiles_by_until ON cairn_past_tiles (until);
CREATE INDEX cairn_past_sessions_by_until ON cairn_past_sessions (until);
CREATE INDEX cairn_past_keyframes_by_until ON cairn_past_keyframes (until);
CREATE INDEX cairn_keyframe_poses_by_camera ON cairn_keyframe_poses (camera_id);
CREATE INDEX keyframes_by_session ON keyframes (session_id, tile_id);
CREATE INDEX keyframes_by_tile ON keyframes (tile_id);
CREATE INDEX coverage_by_geom ON coverage USING gist (geom);
CREATE INDEX keyframes_by_geom ON keyframes USING gist (geom);

-- Payloads are compressed already, and are read whole.
ALTER TABLE cairn_payloads ALTER COLUMN bytes SET STORAGE EXTERNAL;

-- A row without an id gets the next one; a session or a keyframe that comes back keeps its own.
-- Each table has a function of its own: one for all would have to build its statements from the
-- names of column and sequence for each row.

CREATE SEQUENCE cairn_codebook_ids OWNED BY cairn_codebooks.codebook_id;
CREATE FUNCTION cairn_number_codebook() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  IF NEW.codebook_id IS NULL THEN
    NEW.codebook_id := nextval('cairn.cairn_codebook_ids');
  ELSE
    PERFORM setval('cairn.cairn_codebook_ids',
                   greatest(NEW.codebook_id, (SELECT last_value FROM cairn.cairn_codebook_ids)));
  END IF;
  RETURN NEW;
END $$;
CREATE TRIGGER number_rows BEFORE INSERT ON cairn_codebooks
  FOR EACH ROW EXECUTE FUNCTION cairn_number_codebook();

CREATE SEQUENCE cairn_session_ids OWNED BY cairn_sessions.session_id;
CREATE FUNCTION cairn_number_session() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  IF NEW.session_id IS NULL THEN
    NEW.session_id := nextval('cairn.cairn_session_ids');
  ELSE
    PERFORM setval('cairn.cairn_session_ids',
                   greatest(NEW.session_id, (SELECT last_value FROM cairn.cairn_session_ids)));
  END IF;
  RETURN NEW;
END $$;
CREATE TRIGGER number_rows BEFORE INSERT ON cairn_sessions
  FOR EACH ROW EXECUTE FUNCTION cairn_number_session();

CREATE SEQUENCE cairn_keyframe_ids OWNED BY keyframes.keyframe_id;
CREATE FUNCTION cairn_number_keyframe() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  IF NEW.keyframe_id IS NULL THEN
    NEW.keyframe_id := nextval('cairn.cairn_keyframe_ids');
  ELSE
    PERFORM setval('cairn.cairn_keyframe_ids',
                   greatest(NEW.keyframe_id, (SELECT last_value FROM cairn.cairn_keyframe_ids)));
  END IF;
  RETURN NEW;
END $$;
CREATE TRIGGER number_rows BEFORE INSERT ON keyframes
  FOR EACH ROW EXECUTE FUNCTION cairn_number_keyframe();

CREATE SEQUENCE cairn_payload_ids OWNED BY cairn_payloads.payload_id;
CREATE FUNCTION cairn_number_payload() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  IF NEW.payload_id IS NULL THEN
    NEW.payload_id := nextval('cairn.cairn_payload_ids');
  ELSE
    PERFORM setval('cairn.cairn_payload_ids',
                   greatest(NEW.payload_id, (SELECT last_value FROM cairn.cairn_payload_ids)));
  END IF;
  RETURN NEW;
END $$;
CREATE TRIGGER number_rows BEFORE INSERT ON cairn_payloads
  FOR EACH ROW EXECUTE FUNCTION cairn_number_payload();

CREATE SEQUENCE cairn_camera_ids OWNED BY cairn_cameras.camera_id;
CREATE FUNCTION cairn_number_camera() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  IF NEW.camera_id IS NULL THEN
    NEW.camera_id := nextval('cairn.cairn_camera_ids');
  ELSE
    PERFORM setval('cairn.cairn_camera_ids',
                   greatest(NEW.camera_id, (SELECT last_value FROM cairn.cairn_camera_ids)));
  END IF;
  RETURN NEW;
END $$;
CREATE TRIGGER number_rows BEFORE INSERT ON cairn_cameras
  FOR EACH ROW EXECUTE FUNCTION cairn_number_camera();

-- What people look at in QGIS and psql.
CREATE VIEW versions AS
  SELECT version, created_at, author, kind, session, summary, num_sessions, num_keyframes, num_tiles,
         num_landmarks, num_descriptors, payload_bytes,
         CASE WHEN west_deg <= east_deg
              THEN ST_MakeEnvelope(west_deg, south_deg, east_deg, north_deg, 4326) END AS geom
  FROM cairn_versions;

CREATE VIEW sessions AS
  SELECT s.session_id, s.name, s.source, s.recorded_at, s.num_images, s.num_landmarks,
         count(k.keyframe_id) AS num_keyframes, ST_Multi(ST_Collect(k.geom)) AS geom
  FROM cairn_sessions AS s LEFT JOIN keyframes AS k ON k.session_id = s.session_id
  GROUP BY s.session_id;

-- The accuracy of sessions (sql/session_accuracy.sql). Maps that earlier programs made lack it.
CREATE TABLE session_accuracy (
  session_id   bigint           NOT NULL PRIMARY KEY,
  in_map_m     double precision NOT NULL,  -- Of poses in the map, beside what their matches predict.
  on_earth_m   double precision NOT NULL,  -- Of the session's place on Earth.
  on_earth_rad double precision NOT NULL   -- Of its direction on Earth.
);

-- Roles of least privilege, for the whole cluster: GRANT cairn_reader TO the role of a server, and
-- cairn_builder to that of an ingest. Where the creator of the map may not create roles, the tables
-- are the creator's alone.
DO $$
BEGIN
  IF to_regrole('cairn_reader') IS NULL THEN
    CREATE ROLE cairn_reader NOLOGIN;
  END IF;
  IF to_regrole('cairn_builder') IS NULL THEN
    CREATE ROLE cairn_builder NOLOGIN IN ROLE cairn_reader;
  END IF;
EXCEPTION WHEN insufficient_privilege THEN
  RAISE NOTICE 'the roles cairn_reader and cairn_builder are not there';
END $$;

DO $$
BEGIN
  IF to_regrole('cairn_reader') IS NOT NULL AND to_regrole('cairn_builder') IS NOT NULL THEN
    GRANT USAGE ON SCHEMA cairn TO cairn_reader;
    GRANT SELECT ON ALL TABLES IN SCHEMA cairn TO cairn_reader;
    GRANT SELECT ON ALL SEQUENCES IN SCHEMA cairn TO cairn_reader;  -- For pg_dump.
    GRANT INSERT, UPDATE, DELETE ON ALL TABLES IN SCHEMA cairn TO cairn_builder;
    REVOKE INSERT, UPDATE, DELETE ON cairn_migrations FROM cairn_builder;
    GRANT ALL ON ALL SEQUENCES IN SCHEMA cairn TO cairn_builder;
  END IF;
END $$;
