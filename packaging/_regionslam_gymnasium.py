"""Registers the RegionSLAM environments as soon as Gymnasium is imported, and does nothing before.

Gymnasium 1.0 dropped the loader of its `gymnasium.envs` entry points, so a plain `gym.make("RegionSLAM/GoTo-v0")` would
not find us. `regionslam_env.pth` imports this module when the interpreter starts; it costs one small class until
somebody imports `gymnasium`, and then calls what the entry point names: `regionslam_env.registration:register_envs`.
"""

import sys


class _AfterGymnasium:
    """Meta path finder that lets the others find `gymnasium` and registers our environments once it has run."""

    def find_spec(self, name, path=None, target=None):
        if name != "gymnasium":
            return None
        sys.meta_path.remove(self)
        from importlib.util import find_spec

        spec = find_spec(name)
        if spec is not None and spec.loader is not None and hasattr(spec.loader, "exec_module"):
            execute = spec.loader.exec_module

            def exec_module(module):
                execute(module)
                _register()

            spec.loader.exec_module = exec_module
        return spec


def _register():
    """Register; a broken installation of ours must never break Gymnasium for others."""
    try:
        from regionslam_env.registration import register_envs

        register_envs()
    except Exception as error:
        import warnings

        warnings.warn(f"the RegionSLAM environments could not be registered: {error!r}", stacklevel=2)


if "gymnasium" not in sys.modules:
    sys.meta_path.insert(0, _AfterGymnasium())
