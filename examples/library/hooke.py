"""hooke in Python: sessions, and what they find as numpy arrays that point into the library's memory.

    import hooke
    lab = hooke.Session()
    lab.run("scene pendulum; method rk4 dt=1ms; run 20 s")
    run = lab.table("t theta energy")
    print(run["theta"].max(), run.units["theta"])

LIBHOOKE names the library where the system does not find it. Needs numpy.
"""
import ctypes
import os

import numpy


class _Error(ctypes.Structure):
    _fields_ = [("status", ctypes.c_int), ("line", ctypes.c_int), ("column", ctypes.c_int), ("file", ctypes.c_char_p),
                ("code", ctypes.c_char_p), ("message", ctypes.c_char_p), ("hint", ctypes.c_char_p)]


_lib = ctypes.CDLL(os.environ.get("LIBHOOKE", "libhooke.so.0"))
for _name, _result, _arguments in [
    ("version", ctypes.c_char_p, ""),
    ("open", ctypes.c_void_p, "u"),
    ("close", None, "p"),
    ("run", ctypes.c_int, "ps"),
    ("cancel", None, "p"),
    ("output", ctypes.c_char_p, "p"),
    ("messages", ctypes.c_char_p, "p"),
    ("error", ctypes.POINTER(_Error), "p"),
    ("value", ctypes.c_int, "psdd"),
    ("result", ctypes.c_char_p, "pz"),
    ("table", ctypes.c_void_p, "ps"),
    ("table_free", None, "p"),
    ("rows", ctypes.c_size_t, "p"),
    ("columns", ctypes.c_size_t, "p"),
    ("column_name", ctypes.c_char_p, "pz"),
    ("column_unit", ctypes.c_char_p, "pz"),
    ("column", ctypes.POINTER(ctypes.c_double), "ps"),
    ("text", ctypes.c_char_p, "psz"),
]:
    _function = getattr(_lib, "hooke_" + _name)
    _function.restype = _result
    _function.argtypes = [{"u": ctypes.c_uint, "p": ctypes.c_void_p, "s": ctypes.c_char_p, "z": ctypes.c_size_t,
                           "d": ctypes.POINTER(ctypes.c_double)}[a] for a in _arguments]

version = _lib.hooke_version().decode()


class Error(Exception):
    """What hooke says: its sentence, with .status, .line, .column and .hint."""

    def __init__(self, error):
        super().__init__(error.message.decode() + (f"; {error.hint.decode()}" if error.hint else ""))
        self.status, self.line, self.column, self.hint = error.status, error.line, error.column, error.hint.decode()


class Table(dict):
    """Columns by name: arrays of doubles, lists of texts; .units by name. The arrays share the library's memory,
    which is given back when the last of them is gone."""

    def __init__(self, handle):
        super().__init__()
        self.units = {}
        owner = _Owner(handle)
        rows = _lib.hooke_rows(handle)
        for place in range(_lib.hooke_columns(handle)):
            name = _lib.hooke_column_name(handle, place)
            values = _lib.hooke_column(handle, name)
            if values:
                memory = (ctypes.c_double * rows).from_address(ctypes.addressof(values.contents))
                memory.owner = owner
                column = numpy.frombuffer(memory) if rows else numpy.empty(0)
            else:
                column = [(_lib.hooke_text(handle, name, row) or b"").decode() for row in range(rows)]
            self[name.decode()] = column
            self.units[name.decode()] = _lib.hooke_column_unit(handle, place).decode()


class _Owner:
    def __init__(self, handle):
        self.handle = handle

    def __del__(self):
        _lib.hooke_table_free(self.handle)


class Session:
    def __init__(self, safe=False):
        self.handle = _lib.hooke_open(1 if safe else 0)
        if not self.handle:
            raise MemoryError

    def run(self, lines):
        """Executes lines and returns what they print; an error is raised."""
        if _lib.hooke_run(self.handle, lines.encode()) != 0:
            raise Error(_lib.hooke_error(self.handle).contents)
        return _lib.hooke_output(self.handle).decode()

    @property
    def messages(self):
        """Warnings and notes of the last run()."""
        return _lib.hooke_messages(self.handle).decode()

    def __getitem__(self, name):
        """(value, uncertainty) of anything with a name, in SI units."""
        value, uncertainty = ctypes.c_double(), ctypes.c_double()
        if not _lib.hooke_value(self.handle, name.encode(), value, uncertainty):
            raise KeyError(name)
        return value.value, uncertainty.value

    def results(self):
        """The tables that the session keeps: table("table of " + name)."""
        names = []
        while name := _lib.hooke_result(self.handle, len(names)):
            names.append(name.decode())
        return names

    def table(self, what=""):
        """What `export FILE WHAT` would write."""
        handle = _lib.hooke_table(self.handle, what.encode())
        if not handle:
            raise Error(_lib.hooke_error(self.handle).contents)
        return Table(handle)

    def cancel(self):
        """Stops what goes on, from another thread."""
        _lib.hooke_cancel(self.handle)

    def __del__(self):
        if getattr(self, "handle", None):
            _lib.hooke_close(self.handle)
