/* davar-statistics - the commands of the detector's tables. */
#ifndef DAVAR_TESTS_DETECTOR_H
#define DAVAR_TESTS_DETECTOR_H

int detector_command(int argc, char **argv);

#endif
