# Runs the tests that hold on the board too: tests/*/board_*.py, under pytest and under MicroPython.
#
# Such a file holds plain functions test_*() with assert, loops instead of parameters, no fixtures,
# and nothing MicroPython lacks. Under MicroPython: micropython tests/boardtest.py FILE

import gc
import sys

# By name: Blinka, on CPython, installs a module called micropython too.
ON_MICROPYTHON = sys.implementation.name == "micropython"
if ON_MICROPYTHON:
    import micropython

# Where viper is machine code; elsewhere its plain form runs, which may allocate.
HAS_NATIVE = getattr(sys.implementation, "_mpy", 0) >> 10 != 0


def no_allocation(call, times=3):
    # Assert that call() allocates nothing, as machine code. Elsewhere only call it.
    #
    # The locked heap shows what fails in a hard timer callback. It hides a raised exception, which
    # then comes from the emergency buffer; the heap's size shows that.
    if not HAS_NATIVE:
        for _ in range(times):
            call()
        return
    call()  # what is made once, at first use, may be made
    micropython.heap_lock()
    try:
        for _ in range(times):
            call()
        refused = None
    except MemoryError as error:
        refused = error
    finally:
        micropython.heap_unlock()
    assert refused is None, "allocates: %s" % refused
    gc.collect()
    gc.disable()
    try:
        before = gc.mem_alloc()
        for _ in range(times):
            call()
        grown = gc.mem_alloc() - before
    finally:
        gc.enable()
    assert grown == 0, "allocates %d bytes in %d calls" % (grown, times)


def raises(error, call, *args):
    # Assert that call(*args) raises `error`; return its text.
    try:
        call(*args)
    except error as raised:
        return str(raised)
    raise AssertionError("%s not raised" % error.__name__)


def main(file):
    # Run every test of one file, in the order of their names. Returns the number of failures.
    folder, _, name = file.rpartition("/")
    sys.path.append(sys.path.pop(0))  # tests/: its folders are no packages
    sys.path.insert(0, folder or ".")
    module = __import__(name[: -len(".py")])
    passed = 0
    failed = 0
    for test in sorted(name for name in dir(module) if name.startswith("test_")):
        try:
            getattr(module, test)()
            passed += 1
        except Exception as error:
            failed += 1
            print("FAILED", test)
            sys.print_exception(error)
    print("%d passed, %d failed" % (passed, failed))
    return failed or not passed


if __name__ == "__main__":
    sys.exit(1 if main(sys.argv[1]) else 0)
