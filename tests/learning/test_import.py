"""`import atari` imports nothing of `atari.learning`; this and `atari.recording` import neither PyTorch nor PyAV."""

from own_process import run_program


def test_what_is_imported():
    heavy = "{'torch', 'matplotlib', 'stable_baselines3', 'onnxruntime', 'av', 'pygame'}"
    printed = run_program(
        f"""
        import sys
        import atari
        print(sum(name.startswith("atari.learning") for name in sys.modules))
        import atari.learning, atari.recording
        print({heavy} & set(sys.modules))
        """
    )
    assert printed == "0\nset()\n"
