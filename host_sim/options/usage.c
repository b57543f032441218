/* davar-sim - the help text. */
#include "options/usage.h"

#include "davar/version.h"

static const char TEXT[] =
    "usage: davar-sim REC [options]\n"
    "\n"
    "Feeds a recorded gyro signal through the davar library and prints, window by window, the angle random walk\n"
    "and its companions. The arithmetic is the one that runs on the microcontroller.\n"
    "\n"
    "REC: CSV, plain or gzip; '-' is standard input. Optional '# key: value' lines, a header row, then numbers.\n"
    "Columns are named <quantity>_<unit>: time_s, gyro_x_dps, gyro_y_rad_s, gyro_z_counts, temp_degC, ...\n"
    "\n"
    "Recording\n"
    "  --column NAME ...       columns to process; repeat it, or list names with commas, or, behind REC, with spaces\n"
    "                          (default: the first column named gyro_*, else the only one that is not time_s)\n"
    "  --rate HZ               sample rate (default: the median time step)\n"
    "  --gap FACTOR            a time step above FACTOR sample periods is a gap (default 1.5; with --rate: off)\n"
    "\n"
    "Arithmetic\n"
    "  --arith fixed|float     integer counts, or float32 samples (default fixed)\n"
    "  --lsb UNIT_PER_COUNT    size of a count in deg/s, or in the unit of the column\n"
    "                          (default: the finest power of two that holds the recording in 32 bits)\n"
    "  --bits 16|24|32         width of a count; a value beyond it is an error (default 24; needs --lsb)\n"
    "  --full-scale DPS        float: samples beyond it saturate (default: a power of two that holds the recording)\n"
    "\n"
    "Window, in samples\n"
    "  --policy fixed|kurtosis|or|and|glr   who decides its length (default or: kurtosis OR contribution;\n"
    "                          glr: the window begins where the noise changed)\n"
    "  --mode centred|trailing          where the epoch sits in it (default centred)\n"
    "  --false-alarms-per-hour X, --cut-interval S   glr: accepted while nothing changes (0.01; 300)\n"
    "  --block N, --shock-blocks N      glr: samples of a block (10), blocks of a shock (2)\n"
    "  --long-cluster N        glr: slow changes too, of N samples: 4 blocks, 8, ..\n"
    "..\n"
    "                          glr: windows of 2 to 600 blocks, --segment 0, --shrink 64 or more\n"
    "  --window-max N          longest (default 600)\n"
    "  --window-min N          shortest (default 2/3 of the longest)\n"
    "  --segment N             short segment of the contribution test (default 1/6 of the longest)\n"
    "  --kurtosis K1:K2        stable range of the kurtosis (default 2.5:3.3)\n"
    "  --contribution S1:S2    stable range of the sliding kurtosis contribution (default 0:0.07)\n"
    "  --grow N, --shrink N    change per sample (default 2; trailing windows grow by 1)\n"
    "  --taus octave|geometric[:N]|N,N,...   cluster sizes (default octave; geometric: 12)\n"
    "\n"
    "Output\n"
    "  --stride K              a result every K samples (default 1)\n"
    "  --engine grid|edges     of K: same results, other memory\n"
    "  --out csv|jsonl|can:IFACE|slcan:PATH   (default csv; slcan: a tty, or pty to make one and print its name)\n"
    "  --can-base HEX          CAN identifier of the first channel (default 5D0; the next ones 10 apart)\n"
    "  --can-content summary|full|intervals|fd   frames of a result: 6, all values (default), limits too, one CAN FD\n"
    "  --raw                   frames of the samples too, for davarlab live --raw\n"
    "  --baud N                of the serial line (default: as it is)\n"
    "  --model-table FILE      compare every result with an error model (davarlab export MODEL -o FILE.csv): columns\n"
    "                          model_health (above 1: not this model), model_deviation_M; frames DAVAR_Monitor\n"
    "  --device COMMAND        run on a device: COMMAND JOB RESULTS (see port/job/davar_job.h, tools/davar-mcu)\n"
    "  --details               also intervals and difference counts of every ADEV, gaps, coarse, upper bounds of what "
    "is "
    "absent\n"
    "  --pace max|realtime|X   X: times real time (default max)\n"
    "  --progress auto|always|never   on standard error (default auto: on a terminal)\n"
    "  --help, --version\n"
    "\n"
    "An empty field (null in jsonl) is a value that the window cannot support.\n"
    "Exit status: 0 done, 2 bad recording or option (one line on standard error).\n"
    "\n"
    "Examples\n"
    "  davar-sim flight.csv.gz --lsb 0.05 --stride 100 > arw.csv\n"
    "  davar-sim flight.csv --column gyro_x_dps gyro_y_dps --policy fixed --window-max 6000 --out jsonl\n"
    "  zcat flight.csv.gz | davar-sim - --rate 99.3 --mode trailing --pace realtime\n";

void usage_print(FILE *file)
{
    (void)fputs(TEXT, file);
}

void version_print(FILE *file)
{
    (void)fprintf(file, "davar-sim %d.%d.%d\n", DAVAR_VERSION_MAJOR, DAVAR_VERSION_MINOR, DAVAR_VERSION_PATCH);
}
