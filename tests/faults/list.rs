//! The hundred faults, and the tests that hold what becomes of each.

/// Number, fault, and the tests as `file::function`; files are below `tests`, or below `src` where they say so.
const FAULTS: [(u8, &str, &[&str]); 100] = [
    (1, "the file is missing", &["faults/rows.rs::any_file", "cli.rs::what_cannot_be_read_is_named"]),
    (2, "it is a folder", &["faults/rows.rs::any_file", "cli.rs::what_cannot_be_read_is_named"]),
    (3, "it may not be read", &["machine.rs::a_place_that_takes_no_file_leaves_none"]),
    (4, "it has no bytes", &["faults/rows.rs::any_file"]),
    (5, "it is a pipe or a device", &["machine.rs::pipes_devices_and_folders_are_no_parts"]),
    (6, "it grows or shrinks while it is read", &["faults/rows.rs::a_file_that_changes_while_it_is_read_is_refused"]),
    (7, "its suffix promises another format", &["faults/rows.rs::any_file"]),
    (8, "it is something else under a mesh's name", &["faults/rows.rs::any_file"]),
    (9, "it is a pointer of Git LFS", &["faults/rows.rs::any_file"]),
    (10, "it is packed", &["faults/rows.rs::any_file"]),
    (11, "its name is odd", &["machine.rs::pipes_devices_and_folders_are_no_parts"]),
    (12, "one of many is bad", &["batch.rs::one_bad_part_keeps_nobody_waiting_and_the_worst_code_wins"]),
    (13, "it has 20 GB", &["faults/rows.rs::pipes_and_vast_files_are_refused_and_odd_names_work"]),
    (14, "results cannot be written", &["machine.rs::a_place_that_takes_no_file_leaves_none"]),
    (15, "a binary header starts with solid", &["faults/rows.rs::stl_binary"]),
    (16, "the count is the largest there is", &["faults/rows.rs::stl_binary"]),
    (17, "the count is too large", &["faults/rows.rs::stl_binary"]),
    (18, "the count is too small", &["faults/rows.rs::stl_binary"]),
    (19, "the count is 0", &["faults/rows.rs::stl_binary"]),
    (20, "the end is missing", &["faults/rows.rs::stl_binary", "cli.rs::what_cannot_be_read_is_named"]),
    (21, "a byte is too many", &["faults/rows.rs::stl_binary"]),
    (22, "it is shorter than a header", &["faults/rows.rs::stl_binary"]),
    (23, "attribute bytes are set", &["faults/rows.rs::stl_binary"]),
    (24, "a coordinate is no number", &["faults/rows.rs::stl_binary"]),
    (25, "a coordinate is infinite", &["faults/rows.rs::stl_binary"]),
    (26, "coordinates are denormal", &["faults/rows.rs::stl_binary"]),
    (27, "normals are wrong", &["faults/rows.rs::stl_binary"]),
    (28, "bytes stand in the other order", &["faults/rows.rs::stl_binary"]),
    (29, "the header is no text", &["faults/rows.rs::stl_binary"]),
    (30, "lines end otherwise", &["faults/rows.rs::stl_text"]),
    (31, "endsolid is missing", &["faults/rows.rs::stl_text"]),
    (32, "it ends in a vertex", &["faults/rows.rs::stl_text"]),
    (33, "a facet has two or four vertices", &["faults/rows.rs::stl_text"]),
    (34, "decimals have commas", &["faults/rows.rs::stl_text"]),
    (35, "a word is no number", &["faults/rows.rs::stl_text"]),
    (36, "there are several solids", &["faults/rows.rs::stl_text"]),
    (37, "one line is endless", &["faults/rows.rs::stl_text"]),
    (38, "the name holds escape codes", &["faults/rows.rs::stl_text"]),
    (39, "a facet has no normal", &["faults/rows.rs::stl_text"]),
    (40, "an index is out of range", &["faults/rows.rs::obj"]),
    (41, "indices are relative", &["faults/rows.rs::obj"]),
    (42, "faces have many corners", &["faults/rows.rs::obj"]),
    (43, "faces stand before vertices", &["faults/rows.rs::obj"]),
    (44, "there are lines and points only", &["faults/rows.rs::obj"]),
    (45, "it is UTF-16", &["faults/rows.rs::obj"]),
    (46, "a count is 10^12", &["faults/rows.rs::ply"]),
    (47, "a list is 2^31 or negative long", &["faults/rows.rs::ply"]),
    (48, "the header is odd", &["faults/rows.rs::ply"]),
    (49, "properties are not known", &["faults/rows.rs::ply"]),
    (50, "a library elsewhere is named", &["faults/rows.rs::obj"]),
    (51, "a 3MF is no package", &["faults/rows.rs::threemf_packages"]),
    (52, "a checksum is wrong", &["faults/rows.rs::threemf_packages"]),
    (53, "a package is a bomb", &["faults/rows.rs::threemf_bombs"]),
    (54, "a name leads out of the package", &["faults/rows.rs::threemf_packages"]),
    (55, "two parts have one name", &["faults/rows.rs::threemf_packages"]),
    (56, "a part is encrypted", &["faults/rows.rs::threemf_packages"]),
    (57, "there are no models, or two", &["faults/rows.rs::threemf_packages"]),
    (58, "there is a document type", &["faults/rows.rs::threemf_models"]),
    (59, "elements are 10^5 deep", &["faults/rows.rs::threemf_models"]),
    (60, "an item has no object", &["faults/rows.rs::threemf_models"]),
    (61, "an object holds itself", &["faults/rows.rs::threemf_models"]),
    (62, "there are 2^30 instances", &["faults/rows.rs::threemf_bombs"]),
    (63, "a transform is singular, mirrors or is no number", &["faults/rows.rs::threemf_models"]),
    (64, "the unit is another", &["faults/rows.rs::threemf_models"]),
    (65, "an extension is required", &["faults/rows.rs::threemf_models"]),
    (66, "decimals have commas in a model", &["faults/rows.rs::threemf_models"]),
    (67, "a name is given twice", &["faults/rows.rs::threemf_models"]),
    (68, "objects are no parts", &["faults/rows.rs::threemf_models"]),
    (69, "there are scripts", &["faults/rows.rs::threemf_models"]),
    (70, "the directory ends in the long form", &["faults/rows.rs::zip64_end_records_are_read"]),
    (71, "edges are open", &["faults/geometry.rs::holes_are_said_with_the_place_of_the_largest"]),
    (72, "edges have four facets", &["faults/geometry.rs::edges_of_four_facets_and_doubled_bodies_count_once"]),
    (73, "bodies coincide", &["faults/geometry.rs::edges_of_four_facets_and_doubled_bodies_count_once"]),
    (74, "all is inside out", &["faults/geometry.rs::shells_and_facets_wound_the_wrong_way_are_read_as_solid"]),
    (75, "one shell is inside out", &["faults/geometry.rs::shells_and_facets_wound_the_wrong_way_are_read_as_solid"]),
    (76, "some facets are turned", &["faults/geometry.rs::shells_and_facets_wound_the_wrong_way_are_read_as_solid"]),
    (77, "bodies overlap", &["faults/geometry.rs::edges_of_four_facets_and_doubled_bodies_count_once"]),
    (78, "facets have no area", &["faults/geometry.rs::slivers_and_ghosts_are_passed_over_and_counted"]),
    (79, "nothing is enclosed", &["faults/geometry.rs::what_encloses_nothing_is_refused"]),
    (80, "shells are nested, or ghosts", &["faults/geometry.rs::slivers_and_ghosts_are_passed_over_and_counted"]),
    (81, "the surface has one side", &["faults/geometry.rs::what_encloses_nothing_is_refused"]),
    (82, "the size is unlikely", &["faults/geometry.rs::sizes_that_hint_at_another_unit_warn_and_are_never_changed"]),
    (83, "the origin is far", &["faults/geometry.rs::a_part_far_from_the_origin_gets_the_same_answer"]),
    (84, "there are 10^5 bodies", &["faults/geometry.rs::a_hundred_thousand_bodies_are_judged_in_bounded_time"]),
    (85, "there are 20 million facets", &["src/memory.rs::twenty_million_triangles_are_refused_with_their_need"]),
    (86, "a spacing is nonsense", &["cli.rs::words_that_make_no_sense_are_refused"]),
    (87, "a spacing is too fine", &["cli.rs::a_grid_that_is_too_large_says_which_spacing_fits"]),
    (88, "a spacing is too coarse", &["faults/geometry.rs::a_coarse_grid_hides_no_wall"]),
    (89, "a rod is too long", &["faults/geometry.rs::a_grid_that_nobody_has_memory_for_is_refused_before_it_is_made"]),
    (90, "counts are prime or odd", &["direct.rs::every_way_to_count_counts_the_same_pairs"]),
    (91, "the element is larger than the part", &["direct.rs::every_way_to_count_counts_the_same_pairs"]),
    (92, "a part touches its box", &["direct.rs::a_single_pair_is_enough_and_the_last_sample_does_not_wrap"]),
    (93, "limits contradict", &["cli.rs::words_that_make_no_sense_are_refused"]),
    (94, "a limit is met exactly", &["cli.rs::the_exit_code_is_the_verdict"]),
    (95, "memory is limited", &["machine.rs::a_limit_of_the_shell_refuses_in_a_sentence_before_the_kernel_does"]),
    (
        96,
        "the user or a pipe ends it",
        &[
            "machine.rs::a_closed_output_ends_quietly_and_a_full_one_does_not",
            "batch.rs::ctrl_c_leaves_nothing_half_written",
        ],
    ),
    (97, "the machine is set up otherwise", &["machine.rs::language_home_and_threads_change_no_byte"]),
    (
        98,
        "a key is unknown, a schema later",
        &["cli.rs::a_profile_with_an_unknown_key_is_refused_at_its_line", "cli.rs::what_cannot_be_read_is_named"],
    ),
    (
        99,
        "a name is markup",
        &[
            "cli.rs::the_name_of_a_part_is_no_markup",
            "batch.rs::names_break_out_of_no_page_and_no_table",
            "exchange.rs::markdown_has_the_findings_and_escapes_names",
        ],
    ),
    (
        100,
        "something of ours breaks down",
        &["src/cli/command.rs::a_panic_is_one_error_with_its_own_code", "batch.rs::what_breaks_down_is_a_line"],
    ),
];

#[test]
fn every_fault_has_a_test() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    for (at, (number, fault, tests)) in FAULTS.iter().enumerate() {
        assert_eq!(usize::from(*number), at + 1, "{fault}");
        assert!(!tests.is_empty(), "{number}: {fault}");
        for test in *tests {
            let (file, function) = test.split_once("::").expect("file::function");
            let place = if file.starts_with("src/") { root.join(file) } else { root.join("tests").join(file) };
            let text = std::fs::read_to_string(&place).unwrap_or_else(|e| panic!("{number}: {}: {e}", place.display()));
            let at = text.find(&format!("fn {function}(")).unwrap_or_else(|| panic!("{number}: there is no {test}"));
            // The attribute stands just before it, perhaps with another between.
            let before: Vec<&str> = text[..at].lines().rev().take(4).collect();
            assert!(before.contains(&"#[test]") || before.contains(&"    #[test]"), "{number}: {test} is no test");
        }
    }
}
