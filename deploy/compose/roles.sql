-- The role of the servers of compose.yaml. `cairn copy` and `cairn init` let cairn_reader read the
-- map that they make.
CREATE ROLE cairn_reader NOLOGIN;
CREATE ROLE server LOGIN IN ROLE cairn_reader;
