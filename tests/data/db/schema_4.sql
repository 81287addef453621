PRAGMA application_id = 0x746e6472;
PRAGMA user_version = 4;
BEGIN TRANSACTION;
CREATE TABLE design (
  id             INTEGER PRIMARY KEY,
  label          TEXT NOT NULL UNIQUE,
  name           TEXT NOT NULL,
  sha256         TEXT NOT NULL CHECK (length(sha256) = 64),
  toml           TEXT NOT NULL,
  length_m       REAL NOT NULL,
  base_width_m   REAL NOT NULL,
  taper          REAL NOT NULL,
  unit_length_m  REAL NOT NULL,
  spacing_ratio  REAL NOT NULL,
  alpha_deg      REAL NOT NULL,
  beta_deg       REAL NOT NULL,
  holes          INTEGER NOT NULL,
  UNIQUE (name, sha256)
) STRICT;
INSERT INTO "design" VALUES(1,'paper','paper','aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa','[tentacle]',0.75,0.02,0.5,0.03,0.5,90.0,75.0,49);
CREATE TABLE fit (
  id              INTEGER PRIMARY KEY,
  provenance_id   INTEGER NOT NULL REFERENCES provenance (id),
  model           TEXT NOT NULL,
  scope           TEXT NOT NULL,  -- what was fitted, for people
  residual_rms_m  REAL
) STRICT;
INSERT INTO "fit" VALUES(1,3,'fold','design paper',0.0012);
CREATE TABLE fit_parameter (
  fit_id          INTEGER NOT NULL REFERENCES fit (id) ON DELETE CASCADE,
  name            TEXT NOT NULL,
  value           REAL NOT NULL,
  standard_error  REAL,
  identified      INTEGER NOT NULL CHECK (identified IN (0, 1)),
  true_value      REAL,  -- where a virtual rig knows it
  PRIMARY KEY (fit_id, name)
) STRICT, WITHOUT ROWID;
INSERT INTO "fit_parameter" VALUES(1,'stiffness_ratio',1.2,0.1,1,NULL);
CREATE TABLE fit_trial (
  fit_id    INTEGER NOT NULL REFERENCES fit (id) ON DELETE CASCADE,
  trial_id  TEXT NOT NULL REFERENCES trial (id),
  PRIMARY KEY (fit_id, trial_id)
) STRICT, WITHOUT ROWID;
INSERT INTO "fit_trial" VALUES(1,'018bcfe5-6800-7000-8000-000000000000');
CREATE TABLE gripper (
  id                 INTEGER PRIMARY KEY,
  sha256             TEXT NOT NULL UNIQUE CHECK (length(sha256) = 64),
  toml               TEXT NOT NULL,
  tentacles          INTEGER NOT NULL CHECK (tentacles > 0),
  carrier_radius_m   REAL NOT NULL,
  first_azimuth_deg  REAL NOT NULL,
  tilt_deg           REAL NOT NULL,
  handedness         TEXT NOT NULL
) STRICT;
INSERT INTO "gripper" VALUES(1,'bbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbb','[gripper]',8,0.12,22.5,5.0,'mirror');
CREATE TABLE holding (
  trial_id              TEXT PRIMARY KEY REFERENCES simulation (trial_id) ON DELETE CASCADE,
  test                  TEXT NOT NULL CHECK (test IN ('lift', 'load', 'strike', 'release')),
  lifted                INTEGER NOT NULL CHECK (lifted IN (0, 1)),  -- rose with the carrier and stayed
  held                  INTEGER NOT NULL CHECK (held IN (0, 1)),    -- what the test asks; release: let go
  rise_m                REAL,     -- the least above its start after the lift
  shift_m               REAL,     -- the most from where it hung after the lift
  payload_kg            REAL,     -- load: the object and what slipped it; NULL: not lifted, or another test
  payload_is_least      INTEGER NOT NULL CHECK (payload_is_least IN (0, 1)),  -- the largest load did not slip it
  payload_by_rods_mass  REAL,
  strikes               INTEGER,  -- strike: that it withstood
  release_s             REAL,     -- release: from the start of unwinding; NULL: not let go
  rule                  TEXT NOT NULL CHECK (rule <> '')  -- what counts as success, in words
, begins_s REAL) STRICT;
INSERT INTO "holding" VALUES('018bcfe5-6803-7000-8000-000000000003','lift',1,1,0.13,0.002,NULL,0,NULL,NULL,NULL,'the object rose with the carrier and stayed',10.0);
CREATE TABLE label (
  id        INTEGER PRIMARY KEY,
  trial_id  TEXT NOT NULL REFERENCES trial (id),
  at_ns     INTEGER NOT NULL,
  word      TEXT NOT NULL CHECK (word <> ''),  -- a word about the trial, such as "slipped"
  author    TEXT NOT NULL CHECK (author <> '')
) STRICT;
INSERT INTO "label" VALUES(1,'018bcfe5-6800-7000-8000-000000000000',1,'slipped','Ada');
CREATE TABLE link_metrics (
  trial_id             TEXT PRIMARY KEY REFERENCES trial (id),
  provenance_id        INTEGER NOT NULL REFERENCES provenance (id),
  mutual_link          REAL,  -- mean |Lk| over pairs, at the trial's end
  object_link          REAL,  -- mean |Lk| over tentacles
  performance          REAL,  -- mutual + object
  mutual_link_at_zero  REAL,  -- the same at pull 0
  object_link_at_zero  REAL,
  performance_at_zero  REAL
) STRICT;
INSERT INTO "link_metrics" VALUES('018bcfe5-6800-7000-8000-000000000000',2,0.5,0.75,1.25,0.0,0.0,0.0);
CREATE TABLE link_pair (
  trial_id    TEXT NOT NULL REFERENCES link_metrics (trial_id) ON DELETE CASCADE,
  frame       INTEGER NOT NULL,
  tentacle_a  INTEGER NOT NULL,
  tentacle_b  INTEGER NOT NULL CHECK (tentacle_a < tentacle_b),
  time_s      REAL NOT NULL,
  link        REAL,
  gauss       REAL,
  flags       TEXT NOT NULL DEFAULT '',
  PRIMARY KEY (trial_id, frame, tentacle_a, tentacle_b)
) STRICT, WITHOUT ROWID;
INSERT INTO "link_pair" VALUES('018bcfe5-6800-7000-8000-000000000000',99,0,1,9.9,-0.5,-0.4,'');
CREATE TABLE link_tentacle (
  trial_id      TEXT NOT NULL REFERENCES link_metrics (trial_id) ON DELETE CASCADE,
  frame         INTEGER NOT NULL,
  tentacle      INTEGER NOT NULL,
  time_s        REAL NOT NULL,
  self_link     REAL,
  object_link   REAL,
  object_gauss  REAL,
  flags         TEXT NOT NULL DEFAULT '',
  PRIMARY KEY (trial_id, frame, tentacle)
) STRICT, WITHOUT ROWID;
INSERT INTO "link_tentacle" VALUES('018bcfe5-6800-7000-8000-000000000000',99,0,9.9,0.4,0.75,0.7,'');
CREATE TABLE medium (
  id      INTEGER PRIMARY KEY,
  name    TEXT NOT NULL UNIQUE CHECK (name <> ''),
  sha256  TEXT NOT NULL UNIQUE CHECK (length(sha256) = 64)
) STRICT;
INSERT INTO "medium" VALUES(1,'air','dddddddddddddddddddddddddddddddddddddddddddddddddddddddddddddddd');
CREATE TABLE note (
  id        INTEGER PRIMARY KEY,
  trial_id  TEXT NOT NULL REFERENCES trial (id),
  at_ns     INTEGER NOT NULL,
  text      TEXT NOT NULL CHECK (text <> ''),
  author    TEXT NOT NULL CHECK (author <> '')
) STRICT;
INSERT INTO "note" VALUES(1,'018bcfe5-6800-7000-8000-000000000000',1,'slipped twice','Ada');
CREATE TABLE object (
  id        INTEGER PRIMARY KEY,
  label     TEXT NOT NULL UNIQUE,
  sha256    TEXT NOT NULL UNIQUE CHECK (length(sha256) = 64),
  toml      TEXT NOT NULL,
  kind      TEXT NOT NULL,
  radius_m  REAL NOT NULL,
  length_m  REAL NOT NULL,
  mass_kg   REAL NOT NULL
) STRICT;
INSERT INTO "object" VALUES(1,'cylinder 45 x 280 mm','cccccccccccccccccccccccccccccccccccccccccccccccccccccccccccccccc','[object]','cylinder',0.0225,0.28,0.015);
CREATE TABLE outcome (
  id         INTEGER PRIMARY KEY,
  trial_id   TEXT NOT NULL REFERENCES trial (id),
  at_ns      INTEGER NOT NULL,
  grasped    INTEGER NOT NULL CHECK (grasped IN (0, 1)),
  judged_by  TEXT NOT NULL CHECK (judged_by <> ''),
  by_person  INTEGER NOT NULL CHECK (by_person IN (0, 1)),
  method     TEXT NOT NULL DEFAULT '',
  notes      TEXT NOT NULL DEFAULT '',
  load_N     REAL  -- pull-out force, where it was measured
) STRICT;
INSERT INTO "outcome" VALUES(1,'018bcfe5-6800-7000-8000-000000000000',1,1,'Ada',1,'by eye','',NULL);
INSERT INTO "outcome" VALUES(2,'018bcfe5-6801-7000-8000-000000000001',1,0,'Ada',1,'by eye','',NULL);
INSERT INTO "outcome" VALUES(3,'018bcfe5-6802-7000-8000-000000000002',1,1,'Ada',1,'by eye','',NULL);
INSERT INTO "outcome" VALUES(4,'018bcfe5-6803-7000-8000-000000000003',1,1,'Ada',1,'by eye','',NULL);
INSERT INTO "outcome" VALUES(5,'018bcfe5-6801-7000-8000-000000000001',2,1,'rule',0,'mean |object link| >= 0.5','',NULL);
CREATE TABLE provenance (
  id               INTEGER PRIMARY KEY,
  made_ns          INTEGER NOT NULL,
  program_version  TEXT NOT NULL,
  parameters_json  TEXT NOT NULL CHECK (json_valid(parameters_json))
) STRICT;
INSERT INTO "provenance" VALUES(1,5,'tendril 0.1.0','{}');
INSERT INTO "provenance" VALUES(2,5,'tendril 0.1.0','{}');
INSERT INTO "provenance" VALUES(3,5,'tendril 0.1.0','{}');
INSERT INTO "provenance" VALUES(4,1700000000000000000,'tendril 0.1.0','{}');
CREATE TABLE provenance_input (
  provenance_id  INTEGER NOT NULL REFERENCES provenance (id) ON DELETE CASCADE,
  name           TEXT NOT NULL,
  sha256         TEXT NOT NULL CHECK (length(sha256) = 64),
  PRIMARY KEY (provenance_id, name)
) STRICT, WITHOUT ROWID;
INSERT INTO "provenance_input" VALUES(1,'cam0','ffffffffffffffffffffffffffffffffffffffffffffffffffffffffffffffff');
INSERT INTO "provenance_input" VALUES(2,'cam0','ffffffffffffffffffffffffffffffffffffffffffffffffffffffffffffffff');
INSERT INTO "provenance_input" VALUES(3,'cam0','ffffffffffffffffffffffffffffffffffffffffffffffffffffffffffffffff');
CREATE TABLE recording (
  id        INTEGER PRIMARY KEY,
  trial_id  TEXT NOT NULL REFERENCES trial (id),
  role      TEXT NOT NULL CHECK (role <> ''),  -- trial, cam0, servo, detections, curves, ...
  file      TEXT NOT NULL CHECK (file <> ''),  -- relative to the trial's folder
  sha256    TEXT NOT NULL CHECK (length(sha256) = 64),
  frames    INTEGER,
  dropped   INTEGER,
  added_ns  INTEGER NOT NULL,
  UNIQUE (trial_id, role)
) STRICT;
INSERT INTO "recording" VALUES(1,'018bcfe5-6800-7000-8000-000000000000','cam0','cam0.mkv','ffffffffffffffffffffffffffffffffffffffffffffffffffffffffffffffff',100,0,1);
INSERT INTO "recording" VALUES(2,'018bcfe5-6801-7000-8000-000000000001','cam0','cam0.mkv','ffffffffffffffffffffffffffffffffffffffffffffffffffffffffffffffff',100,0,1);
INSERT INTO "recording" VALUES(3,'018bcfe5-6802-7000-8000-000000000002','cam0','cam0.mkv','ffffffffffffffffffffffffffffffffffffffffffffffffffffffffffffffff',100,0,1);
INSERT INTO "recording" VALUES(4,'018bcfe5-6803-7000-8000-000000000003','cam0','cam0.mkv','ffffffffffffffffffffffffffffffffffffffffffffffffffffffffffffffff',100,0,1);
CREATE TABLE rig (
  id      INTEGER PRIMARY KEY,
  label   TEXT NOT NULL UNIQUE,
  name    TEXT NOT NULL,
  sha256  TEXT NOT NULL CHECK (length(sha256) = 64),
  toml    TEXT NOT NULL,
  UNIQUE (name, sha256)
) STRICT;
INSERT INTO "rig" VALUES(1,'bench','bench','eeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeee','name = "bench"');
CREATE TABLE scene (
  id      INTEGER PRIMARY KEY,
  name    TEXT NOT NULL,
  sha256  TEXT NOT NULL UNIQUE CHECK (length(sha256) = 64),
  toml    TEXT NOT NULL
) STRICT;
INSERT INTO "scene" VALUES(1,'octagon','cccccccccccccccccccccccccccccccccccccccccccccccccccccccccccccccc','duration = 10');
CREATE TABLE simulation (
  trial_id               TEXT PRIMARY KEY REFERENCES trial (id),
  provenance_id          INTEGER NOT NULL REFERENCES provenance (id),
  scene_id               INTEGER NOT NULL REFERENCES scene (id),
  level                  TEXT NOT NULL CHECK (level IN ('paper', 'standard', 'fast', 'static')),
  seed                   INTEGER NOT NULL,
  trial_number           INTEGER NOT NULL,  -- counts in the random draws, with the seed
  time_step_s            REAL NOT NULL,     -- taken; 0: equilibria without steps
  steps                  INTEGER NOT NULL,
  simulated_s            REAL NOT NULL,     -- reached
  wall_s                 REAL NOT NULL,
  terms_json             TEXT NOT NULL CHECK (json_valid(terms_json)),  -- what the plan switched on and why
  least_axis_distance_m  REAL,              -- of axes that touched; NULL: nothing did
  least_axis_share       REAL,              -- of the radii's sum
  longest_move_m         REAL,              -- of a node in a step
  nothing_passed         INTEGER CHECK (nothing_passed IN (0, 1)),  -- certificate; NULL: not looked at
  divergence             TEXT               -- why it stopped; NULL: it did not diverge
, trusted INTEGER NOT NULL DEFAULT 1 CHECK (trusted IN (0, 1)), doubts TEXT NOT NULL DEFAULT '', longest_stick_share REAL, friction REAL, medium TEXT, run_key TEXT) STRICT;
INSERT INTO "simulation" VALUES('018bcfe5-6803-7000-8000-000000000003',4,1,'standard',1,0,0.0001,100000,10.0,1.5,'[]',0.0197,0.92,0.0001,1,NULL,0,'bodies overlap by 30 % of a radius',0.02,0.4,'air','before 4: scene 1, design 1, level standard, trial 0, then , full 0, set ');
CREATE TABLE track (
  trial_id             TEXT PRIMARY KEY REFERENCES trial (id),
  provenance_id        INTEGER NOT NULL REFERENCES provenance (id),
  frames               INTEGER NOT NULL,
  tentacles            INTEGER NOT NULL,
  rms_reprojection_px  REAL,
  seen_fraction        REAL,
  rms_sigma_m          REAL
) STRICT;
INSERT INTO "track" VALUES('018bcfe5-6800-7000-8000-000000000000',1,100,8,0.2,0.9,0.0005);
CREATE TABLE trial (
  id                 TEXT PRIMARY KEY CHECK (length(id) = 36),  -- UUIDv7, sorts by time
  label              TEXT NOT NULL UNIQUE CHECK (label <> ''),
  kind               TEXT NOT NULL CHECK (kind IN ('real', 'virtual', 'simulated', 'published')),
  state              TEXT NOT NULL CHECK (state IN ('recording', 'recorded', 'degraded', 'aborted', 'failed')),
  state_reason       TEXT NOT NULL DEFAULT '',
  started_ns         INTEGER NOT NULL,
  design_id          INTEGER NOT NULL REFERENCES design (id),
  gripper_id         INTEGER NOT NULL REFERENCES gripper (id),
  object_id          INTEGER NOT NULL REFERENCES object (id),
  medium_id          INTEGER NOT NULL REFERENCES medium (id),
  rig_id             INTEGER REFERENCES rig (id),  -- NULL: no cameras
  object_distance_m  REAL NOT NULL,                -- carrier to object
  object_x_m         REAL NOT NULL,
  object_y_m         REAL NOT NULL,
  object_z_m         REAL NOT NULL,
  pull               REAL NOT NULL CHECK (pull BETWEEN 0 AND 1),  -- commanded, of the flat tendon length
  pull_rate_per_s    REAL NOT NULL,
  tag_family         TEXT NOT NULL,
  tag_footprint_m    REAL NOT NULL,
  tag_first_id       INTEGER NOT NULL,
  notes              TEXT NOT NULL DEFAULT ''
) STRICT;
INSERT INTO "trial" VALUES('018bcfe5-6800-7000-8000-000000000000','first','real','recorded','',1700000000000000000,1,1,1,1,1,0.15,0.0,0.0,-0.15,0.3,0.03,'tag36h11',0.008,0,'');
INSERT INTO "trial" VALUES('018bcfe5-6801-7000-8000-000000000001','second','real','degraded','',1700000001000000000,1,1,1,1,1,0.15,0.0,0.0,-0.15,0.3,0.03,'tag36h11',0.008,0,'');
INSERT INTO "trial" VALUES('018bcfe5-6802-7000-8000-000000000002','void','real','recorded','',1700000002000000000,1,1,1,1,1,0.15,0.0,0.0,-0.15,0.3,0.03,'tag36h11',0.008,0,'');
INSERT INTO "trial" VALUES('018bcfe5-6803-7000-8000-000000000003','rendered','virtual','recorded','',1700000003000000000,1,1,1,1,1,0.15,0.0,0.0,-0.15,0.3,0.03,'tag36h11',0.008,0,'');
CREATE TABLE void (
  id        INTEGER PRIMARY KEY,
  trial_id  TEXT NOT NULL REFERENCES trial (id),
  at_ns     INTEGER NOT NULL,
  reason    TEXT NOT NULL CHECK (reason <> ''),
  author    TEXT NOT NULL CHECK (author <> '')
) STRICT;
INSERT INTO "void" VALUES(1,'018bcfe5-6802-7000-8000-000000000002',1,'string tore','Ada');
CREATE INDEX trial_by_design ON trial (design_id);
CREATE TRIGGER trial_is_fixed
BEFORE UPDATE OF id, kind, started_ns, design_id, gripper_id, object_id, medium_id, rig_id, object_distance_m,
                 pull, pull_rate_per_s ON trial
BEGIN SELECT RAISE(ABORT, 'what a trial was made with never changes: void it and make another'); END;
CREATE INDEX outcome_by_trial ON outcome (trial_id);
CREATE INDEX label_by_trial ON label (trial_id);
CREATE INDEX note_by_trial ON note (trial_id);
CREATE INDEX void_by_trial ON void (trial_id);
CREATE TRIGGER outcome_no_update BEFORE UPDATE ON outcome
BEGIN SELECT RAISE(ABORT, 'outcomes are only ever added to'); END;
CREATE TRIGGER outcome_no_delete BEFORE DELETE ON outcome
BEGIN SELECT RAISE(ABORT, 'outcomes are only ever added to'); END;
CREATE TRIGGER outcome_no_replace BEFORE INSERT ON outcome
WHEN EXISTS (SELECT 1 FROM outcome WHERE id = NEW.id)
BEGIN SELECT RAISE(ABORT, 'outcomes are only ever added to'); END;
CREATE TRIGGER label_no_update BEFORE UPDATE ON label
BEGIN SELECT RAISE(ABORT, 'labels are only ever added to'); END;
CREATE TRIGGER label_no_delete BEFORE DELETE ON label
BEGIN SELECT RAISE(ABORT, 'labels are only ever added to'); END;
CREATE TRIGGER label_no_replace BEFORE INSERT ON label
WHEN EXISTS (SELECT 1 FROM label WHERE id = NEW.id)
BEGIN SELECT RAISE(ABORT, 'labels are only ever added to'); END;
CREATE TRIGGER note_no_update BEFORE UPDATE ON note
BEGIN SELECT RAISE(ABORT, 'notes are only ever added to'); END;
CREATE TRIGGER note_no_delete BEFORE DELETE ON note
BEGIN SELECT RAISE(ABORT, 'notes are only ever added to'); END;
CREATE TRIGGER note_no_replace BEFORE INSERT ON note
WHEN EXISTS (SELECT 1 FROM note WHERE id = NEW.id)
BEGIN SELECT RAISE(ABORT, 'notes are only ever added to'); END;
CREATE TRIGGER void_no_update BEFORE UPDATE ON void
BEGIN SELECT RAISE(ABORT, 'a void trial stays void'); END;
CREATE TRIGGER void_no_delete BEFORE DELETE ON void
BEGIN SELECT RAISE(ABORT, 'a void trial stays void'); END;
CREATE TRIGGER void_no_replace BEFORE INSERT ON void
WHEN EXISTS (SELECT 1 FROM void WHERE id = NEW.id)
BEGIN SELECT RAISE(ABORT, 'a void trial stays void'); END;
CREATE VIEW outcome_current AS
SELECT id, trial_id, at_ns, grasped, judged_by, by_person, method, notes, load_N
FROM (SELECT *, row_number() OVER (PARTITION BY trial_id ORDER BY by_person DESC, at_ns DESC, id DESC) AS place
      FROM outcome)
WHERE place = 1;
CREATE VIEW link_by_trial AS
SELECT t.trial_id, t.label, t.kind, t.state, t.voided, t.design, t.medium, t.distance_m, t.pull, t.grasped,
       l.mutual_link, l.object_link, l.performance,
       l.mutual_link_at_zero, l.object_link_at_zero, l.performance_at_zero,
       p.program_version, p.parameters_json
FROM link_metrics l
JOIN trial_overview t ON t.trial_id = l.trial_id
JOIN provenance p ON p.id = l.provenance_id;
CREATE VIEW fit_latest AS
SELECT f.id AS fit_id, f.model, f.scope, q.name, q.value, q.standard_error, q.identified, q.true_value,
       f.residual_rms_m,
       (SELECT count(*) FROM fit_trial n WHERE n.fit_id = f.id) AS trials,
       (SELECT group_concat(DISTINCT t.kind) FROM fit_trial n JOIN trial t ON t.id = n.trial_id
        WHERE n.fit_id = f.id) AS kinds,
       strftime('%Y-%m-%d %H:%M:%S', p.made_ns / 1000000000, 'unixepoch') AS made_utc,
       p.program_version
FROM fit f
JOIN fit_parameter q ON q.fit_id = f.id
JOIN provenance p ON p.id = f.provenance_id
WHERE f.id = (SELECT max(g.id) FROM fit g WHERE g.model = f.model AND g.scope = f.scope);
CREATE VIEW made_from AS
SELECT w.what, w.trial_id, w.fit_id, i.name AS input, i.sha256, p.program_version, p.parameters_json,
       strftime('%Y-%m-%d %H:%M:%S', p.made_ns / 1000000000, 'unixepoch') AS made_utc
FROM (SELECT 'track' AS what, trial_id, NULL AS fit_id, provenance_id FROM track
      UNION ALL SELECT 'link', trial_id, NULL, provenance_id FROM link_metrics
      UNION ALL SELECT 'fit', NULL, id, provenance_id FROM fit) w
JOIN provenance p ON p.id = w.provenance_id
LEFT JOIN provenance_input i ON i.provenance_id = p.id;
CREATE INDEX simulation_by_scene ON simulation (scene_id);
CREATE VIEW simulation_overview AS
SELECT trial.label, scene.name AS scene, simulation.level, simulation.seed, simulation.trial_number,
       simulation.friction, simulation.medium, simulation.simulated_s, simulation.wall_s,
       simulation.trusted, simulation.doubts, simulation.nothing_passed, simulation.least_axis_share,
       simulation.longest_stick_share, simulation.divergence,
       holding.test, holding.lifted, holding.held, holding.rise_m, holding.shift_m, holding.payload_kg,
       holding.payload_is_least, holding.payload_by_rods_mass, holding.strikes, holding.release_s,
       outcome_current.grasped,
       link_metrics.mutual_link, link_metrics.object_link, link_metrics.performance
FROM simulation
JOIN trial ON trial.id = simulation.trial_id
JOIN scene ON scene.id = simulation.scene_id
LEFT JOIN holding ON holding.trial_id = simulation.trial_id
LEFT JOIN outcome_current ON outcome_current.trial_id = simulation.trial_id
LEFT JOIN link_metrics ON link_metrics.trial_id = simulation.trial_id;
CREATE INDEX simulation_by_run ON simulation (run_key);
CREATE VIEW trial_overview AS
SELECT t.id AS trial_id,
       t.label,
       t.kind,
       t.state,
       EXISTS (SELECT 1 FROM void v WHERE v.trial_id = t.id) AS voided,
       strftime('%Y-%m-%d %H:%M:%S', t.started_ns / 1000000000, 'unixepoch') AS started_utc,
       d.label AS design,
       d.taper,
       d.spacing_ratio,
       d.alpha_deg,
       d.beta_deg,
       g.tentacles,
       g.carrier_radius_m,
       g.handedness,
       o.label AS object,
       o.kind AS object_kind,
       o.radius_m AS object_radius_m,
       o.mass_kg AS object_mass_kg,
       m.name AS medium,
       r.label AS rig,
       t.object_distance_m AS distance_m,
       t.pull,
       t.pull_rate_per_s,
       c.grasped,
       c.judged_by,
       c.by_person,
       c.method,
       c.load_N,
       l.mutual_link,
       l.object_link,
       l.performance,
       k.rms_reprojection_px,
       k.seen_fraction,
       t.started_ns,
       coalesce(s.trusted, 1) AS trusted,
       s.run_key,
       CASE WHEN s.trial_id IS NOT NULL THEN coalesce(h.test, 'none') END AS test,
       s.level,
       s.friction
FROM trial t
JOIN design d ON d.id = t.design_id
JOIN gripper g ON g.id = t.gripper_id
JOIN object o ON o.id = t.object_id
JOIN medium m ON m.id = t.medium_id
LEFT JOIN rig r ON r.id = t.rig_id
LEFT JOIN outcome_current c ON c.trial_id = t.id
LEFT JOIN link_metrics l ON l.trial_id = t.id
LEFT JOIN track k ON k.trial_id = t.id
LEFT JOIN simulation s ON s.trial_id = t.id
LEFT JOIN holding h ON h.trial_id = t.id;
CREATE VIEW judged_run AS
SELECT * FROM trial_overview
WHERE state IN ('recorded', 'degraded') AND NOT voided AND grasped IS NOT NULL;
CREATE VIEW judged_trial AS
SELECT * FROM judged_run
WHERE trial_id IN (SELECT max(trial_id) FROM judged_run GROUP BY coalesce(run_key, trial_id));
CREATE VIEW grasp_rate_input AS
SELECT * FROM judged_trial WHERE trusted;
COMMIT;
