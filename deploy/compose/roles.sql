-- The role `server` of compose.yaml. `cairn copy` and `cairn init` grant cairn_reader the right to
-- read the map that they make.
CREATE ROLE cairn_reader NOLOGIN;
CREATE ROLE server LOGIN IN ROLE cairn_reader;
