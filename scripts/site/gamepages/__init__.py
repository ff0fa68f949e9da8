"""The pages of the games: text from the game definitions, manuals and published scores; media from the replays."""
