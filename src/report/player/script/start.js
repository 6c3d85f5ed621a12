for (const figure of document.querySelectorAll(".player")) startPlayer(figure);
