"""The compile cache under the name that it has had: it lives in `native`, where the judge may reach it too."""

from mcdas_opt.native.compile_cache import HEAD as HEAD
from mcdas_opt.native.compile_cache import SWITCH as SWITCH
from mcdas_opt.native.compile_cache import NoLibraryError as NoLibraryError
from mcdas_opt.native.compile_cache import cache_folder as cache_folder
from mcdas_opt.native.compile_cache import compiler as compiler
from mcdas_opt.native.compile_cache import load as load
from mcdas_opt.native.compile_cache import to_stderr as to_stderr
