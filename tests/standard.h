// As common/standard.h, for the tests.
#include <gtest/gtest.h>

#include "common/standard.h"
