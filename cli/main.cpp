#include "cli/command.h"

int main(int argc, char** argv) { return tendril::cli::Main(argc, argv); }
