"""Bad recordings: exit status 2, one line with file, line and column, no standard output."""

import os
import resource
import signal
import subprocess
import unittest

from sim_case import PROGRAM, SMALL_WINDOW, SimCase, as_text, noise_rows

HEADER = "time_s,gyro_x_dps,temp_degC"
BAD_FIELDS = {
    "abc": "not a number",
    "": "empty field",
    "  ": "empty field",
    "nan": "not a finite number",
    "NaN": "not a finite number",
    "-nan": "not a finite number",
    "inf": "not a finite number",
    "-Infinity": "not a finite number",
    "1e999": "too large",
    "-1e999": "too large",
    "1" * 400: "too large",
    "0x10": "not a number",
    "1.2.3": "not a number",
    "1e+": "not a number",
    "--1": "not a number",
    ".": "not a number",
    "1 2": "not a number",
    "1;2": "not a number",
    "# 1": "not a number",
    '"1"': "not a number",
    "1\v": "not a number",
}


class BadRecording(SimCase):
    def refuse(self, content, *words, name="rec.csv", options=SMALL_WINDOW):
        path = self.write(name, content)
        self.assert_refused(self.sim(path, *options), path, *words)

    def rows(self, count=200):
        return noise_rows(count, columns=2)

    def text_with(self, row, column, field):
        rows = self.rows()
        rows[row][column] = field
        return as_text(HEADER, rows)

    # --- fields

    def test_a_bad_number_is_reported_with_line_and_column(self):
        for field, what in BAD_FIELDS.items():
            with self.subTest(field=field):
                self.refuse(
                    self.text_with(99, 1, field), ":101: column gyro_x_dps: ", what, "found '"
                )

    def test_fields_of_unselected_columns_are_checked_too(self):
        self.refuse(
            self.text_with(99, 2, "warm"), ":101: column temp_degC: not a number, found 'warm'"
        )

    def test_the_time_column_is_checked(self):
        self.refuse(
            self.text_with(99, 0, "noon"), ":101: column time_s: not a number, found 'noon'"
        )

    def test_the_first_and_the_last_row_are_checked(self):
        self.refuse(self.text_with(0, 1, "x"), ":2: column gyro_x_dps")
        self.refuse(self.text_with(199, 1, "x"), ":201: column gyro_x_dps")
        self.refuse(self.text_with(199, 2, "x").rstrip("\n"), ":201: column temp_degC")

    def test_lines_are_counted_with_comments_and_blank_lines_before_the_header(self):
        self.refuse("# sensor: none\n\n" + self.text_with(99, 1, "x"), ":103: column gyro_x_dps")

    def test_a_long_bad_field_is_shown_in_part(self):
        done = self.sim(self.write("rec.csv", self.text_with(9, 1, "x" * 5000)))
        self.assert_refused(done, ":11: column gyro_x_dps: not a number, found 'xxx", "...'")
        self.assertLess(len(done.stderr), 400)

    def test_a_bad_field_is_found_in_a_gzip_file_too(self):
        self.refuse(self.text_with(99, 1, "x"), ":101: column gyro_x_dps", name="rec.csv.gz")

    # --- rows

    def test_a_short_row_names_the_missing_column(self):
        rows = self.rows()
        rows[50] = rows[50][:2]
        self.refuse(as_text(HEADER, rows), ":52: column temp_degC: row too short", "found 2")

    def test_a_long_row_is_rejected(self):
        rows = self.rows()
        rows[50] += ["1", "2"]
        self.refuse(as_text(HEADER, rows), ":52: column 4: row too long", "found 5")

    def test_a_trailing_comma_is_one_field_too_many(self):
        rows = self.rows()
        rows[50][2] += ","
        self.refuse(as_text(HEADER, rows), ":52: column 4: row too long")

    def test_a_blank_line_between_rows_is_rejected_with_its_line(self):
        rows = self.rows()
        lines = as_text(HEADER, rows).split("\n")
        lines.insert(51, "")
        self.refuse("\n".join(lines), ":52: ", "empty row")

    def test_a_comment_between_rows_is_rejected(self):
        lines = as_text(HEADER, self.rows()).split("\n")
        lines.insert(51, "# pause")
        self.refuse("\n".join(lines), ":52: column time_s: not a number, found '# pause'")

    def test_a_zero_byte_in_a_row_is_rejected(self):
        rows = self.rows()
        rows[50][2] += "\0garbage"
        self.refuse(as_text(HEADER, rows), ":52: ", "0x00")

    def test_an_endless_line_is_rejected(self):
        self.refuse("time_s,gyro_x_dps\n0,1\n" + "1" * 1000000, ":3: ", "line longer")

    # --- time

    def test_time_running_backwards_is_rejected(self):
        rows = self.rows()
        rows[60][0] = rows[58][0]
        self.refuse(as_text(HEADER, rows), ":62: column time_s: time runs backwards, found '0.58'")

    def test_time_running_backwards_is_rejected_even_when_the_rate_is_given(self):
        rows = self.rows()
        rows[60][0] = "-1"
        self.refuse(
            as_text(HEADER, rows), ":62: column time_s", options=("--rate", "100", *SMALL_WINDOW)
        )

    def test_constant_time_gives_no_rate(self):
        rows = [["7", row[1], row[2]] for row in self.rows()]
        self.refuse(as_text(HEADER, rows), "column time_s: the median time step is 0", "--rate")

    def test_no_time_and_no_rate(self):
        self.refuse(as_text("gyro_x_dps", [[row[1]] for row in self.rows()]), "time_s", "--rate")

    # --- header

    def test_a_column_name_used_twice(self):
        self.refuse(
            as_text("time_s,gyro_x_dps,gyro_x_dps", self.rows()), ":1: column 3: name used twice"
        )

    def test_an_empty_column_name(self):
        self.refuse(as_text("time_s,,gyro_x_dps", self.rows()), ":1: column 2: empty name")

    def test_numbers_where_the_header_should_be(self):
        self.refuse(
            as_text("0.0,1.5,20", self.rows()), ":1: column 1: no header row", "found '0.0'"
        )

    def test_unknown_column_lists_the_columns(self):
        path = self.write("rec.csv", as_text(HEADER, self.rows()))
        self.assert_refused(
            self.sim(path, "--column", "gyro_q_dps"),
            path,
            "gyro_q_dps",
            "--column",
            "time_s, gyro_x_dps, temp_degC",
        )

    def test_no_gyro_column_and_several_others_lists_them(self):
        self.refuse(
            as_text("time_s,temp_degC,accel_x_g", self.rows()),
            "--column",
            "time_s, temp_degC, accel_x_g",
        )

    def test_counts_without_lsb(self):
        self.refuse("time_s,gyro_x_counts\n0,1\n1,2\n", "column gyro_x_counts", "--lsb")

    # --- values

    def test_a_value_beyond_the_count_range(self):
        options = ("--lsb", "0.01", "--bits", "16", *SMALL_WINDOW)
        self.refuse(
            self.text_with(99, 1, "327.68"),
            ":101: column gyro_x_dps: value outside the count range",
            "found '327.68'",
            options=options,
        )
        self.refuse(self.text_with(99, 1, "-327.69"), ":101: column gyro_x_dps", options=options)

    def test_the_default_count_range_has_24_bits(self):
        options = ("--lsb", "0.01", *SMALL_WINDOW)
        self.refuse(self.text_with(99, 1, "83886.08"), ":101: column gyro_x_dps", options=options)
        self.refuse(self.text_with(99, 1, "1e300"), ":101: column gyro_x_dps", options=options)

    def test_counts_that_are_not_integers(self):
        rows = self.rows(200)
        counts = [[row[0], str(i)] for i, row in enumerate(rows)]
        counts[77][1] = "12.5"
        self.refuse(
            as_text("time_s,gyro_x_counts", counts),
            ":79: column gyro_x_counts: not a whole count",
            "found '12.5'",
            options=("--lsb", "0.1", *SMALL_WINDOW),
        )

    def test_a_value_beyond_float32(self):
        self.refuse(
            self.text_with(99, 1, "1e39"),
            ":101: column gyro_x_dps",
            options=("--arith", "float", *SMALL_WINDOW),
        )

    # --- files

    def test_missing_file(self):
        path = self.folder / "nothing.csv"
        self.assert_refused(self.sim(path), path, "No such file")

    def test_directory(self):
        self.assert_refused(self.sim(self.folder), self.folder, "directory")

    def test_devices_and_links_to_nowhere(self):
        """Pipes and standard input are read (test_recording.py); a device may have no end."""
        loop, long, pipe = (
            self.folder / "loop.csv",
            self.folder / ("a" * 300),
            self.folder / "new\nline.csv",
        )
        loop.symlink_to(loop)
        for path, words in (
            ("/dev/zero", "device"),
            ("/dev/null", "device"),
            ("/proc/kmsg", ""),
            (loop, "symbolic links"),
            (long, "too long"),
            (pipe, "No such file"),
        ):
            self.assert_refused(self.sim(path), str(path).split("\n")[0], words)

    def test_empty_file(self):
        self.refuse("", "empty recording")
        self.refuse("", "empty recording", name="empty.csv.gz")
        self.refuse("# only: comments\n\n", "empty recording")

    def test_header_only(self):
        self.refuse(HEADER + "\n", ":1: no rows")
        self.refuse(HEADER, ":1: no rows")

    def test_binary(self):
        self.refuse(bytes(range(256)) * 64, ":1: not a text recording")
        self.refuse("time_s,gyro_x_dps\n0,1\n".encode("utf-16"), ":1: not a text recording")
        self.refuse(bytes(1000), ":1: not a text recording, found byte 0x00")

    def test_binary_after_a_good_header(self):
        self.refuse(HEADER.encode() + b"\n" + bytes(range(256)) * 64, ":2: ")

    def test_too_short_reports_how_many_samples_are_needed(self):
        path = self.recording(count=29)
        self.assert_refused(self.sim(path, *SMALL_WINDOW), path, "29 samples", "at least 30")
        self.assert_refused(
            self.sim(path, *SMALL_WINDOW, "--mode", "trailing"), path, "29 samples", "at least 40"
        )
        self.assert_refused(
            self.sim(path, *SMALL_WINDOW, "--stride", "35"), path, "29 samples", "at least 35"
        )

    def test_one_row(self):
        self.refuse("time_s,gyro_x_dps\n0,1\n", "1 samples", "at least 30")

    def test_the_stated_number_of_samples_is_enough(self):
        self.assertEqual(30, len(self.results(self.recording(count=30), *SMALL_WINDOW)))
        self.assertEqual(
            1, len(self.results(self.recording(count=40), *SMALL_WINDOW, "--mode", "trailing"))
        )
        self.assertEqual(
            1, len(self.results(self.recording(count=35), *SMALL_WINDOW, "--stride", "35"))
        )


class BadSurroundings(SimCase):
    """The system around the program fails."""

    def test_no_room_for_the_temporary_file(self):
        environment = dict(os.environ, TMPDIR=str(self.folder / "nowhere"))
        self.assert_refused(
            self.sim(self.recording(), env=environment), "nowhere", "TMPDIR", "No such file"
        )

    def test_a_full_temporary_folder(self):
        def limit():
            resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)

        path = self.recording(count=60000)
        self.assert_refused(self.sim(path, preexec_fn=limit), "temporary file", "cannot write")

    def test_a_full_disk_for_the_output(self):
        with open("/dev/full", "wb") as full:
            done = subprocess.run(
                [PROGRAM, self.recording(), "--lsb", "0.01"], stdout=full, stderr=subprocess.PIPE
            )
        self.assertEqual(2, done.returncode)
        self.assertEqual(b"davar-sim: standard output: No space left on device\n", done.stderr)

    def test_standard_output_may_not_be_the_recording(self):
        path = self.recording()
        text = path.read_bytes()
        other = self.folder / "other.csv"
        other.hardlink_to(path)
        for name, stdin in ((path, None), (other, None), ("-", path)):
            with (
                self.subTest(name=name),
                open(path, "ab") as output,
                open(stdin or os.devnull, "rb") as source,
            ):
                done = subprocess.run(
                    [PROGRAM, name, "--lsb", "0.01"],
                    stdin=source,
                    stdout=output,
                    stderr=subprocess.PIPE,
                    text=True,
                )
                self.assertEqual(2, done.returncode)
                self.assertEqual(
                    f"davar-sim: {name}: is also standard output: results would be read as data\n",
                    done.stderr,
                )
            self.assertEqual(text, path.read_bytes())

    def test_closed_standard_output(self):
        done = subprocess.run(
            ["sh", "-c", 'exec "$0" "$1" --lsb 0.01 >&-', PROGRAM, self.recording()],
            stderr=subprocess.PIPE,
        )
        self.assertEqual(2, done.returncode)
        self.assertEqual(b"davar-sim: standard output: Bad file descriptor\n", done.stderr)

    def test_a_disconnected_reader_ends_the_run_quietly(self):
        path = self.recording(count=20000)
        done = subprocess.run(
            ["sh", "-c", '"$0" "$1" --lsb 0.01 | head -n 1', PROGRAM, path],
            capture_output=True,
        )
        self.assertEqual(b"", done.stderr)
        self.assertTrue(done.stdout.startswith(b"epoch,time_s,"))


if __name__ == "__main__":
    unittest.main()
